// What the camera sees, per pixel: receivers are made of it. Rays find it, so that pixels, records
// and the rays of both see one and the same surface: a rasteriser picks another triangle in a pixel
// of a thousand.
#pragma once

#include <span>

#include "gl/worker_pool.h"
#include "image/image.h"
#include "raster/gpu_scene.h"
#include "raster/view.h"
#include "rays/surface_point.h"
#include "rays/tracer.h"

namespace sheen {

/// Row 0 on top. Pixels without geometry have depth 0 and triangle kNoPrimitive.
struct GBuffer {
    PixelGrid image;
    Image<vec3> position;  ///< world space
    Image<float> depth;    ///< along the view axis; of a bent ray, of as long a straight one
    Image<vec3> normal;    ///< shading normal, world space
    /// By normal maps, for direct light; empty where no material has one. Records stand on, and
    /// serve, the smooth surface.
    Image<vec3> mapped_normal;
    Image<vec3> diffuse;     ///< diffuse reflectance toward the camera
    Image<vec3> f0;          ///< specular F0
    Image<float> f90;        ///< specular F90
    Image<float> roughness;  ///< perceptual
    // Of clear coats; empty where no material has one.
    Image<float> coat;            ///< how much of the surface is coated
    Image<float> coat_roughness;  ///< perceptual
    Image<vec3> coat_normal;      ///< by normal maps of their own; empty where none has one
    Image<vec3> direct;           ///< radiance of direct light
    Image<vec3> emission;         ///< radiance; empty where no material emits and no sky shows
    Image<uint32_t> primitive;
    /// What share of the light from there the pixel sees, through glass of each channel another;
    /// empty where it is all of it everywhere.
    Image<vec3> share;
    /// From where each is seen whose ray glass has bent: so far off as the ray travelled, on the
    /// way by which it came; the camera's place for all others. Empty where no glass bends any.
    Image<vec3> eye;
    /// How many blended surfaces lie before what is behind them, at most.
    int veils = 0;

    /// By which direct light is scattered.
    const vec3& mappedNormalAt(size_t i) const {
        return (mapped_normal.empty() ? normal : mapped_normal).pixels[i];
    }
    vec3 shareAt(size_t i) const { return share.empty() ? vec3(1.0f) : share.pixels[i]; }
    bool seen(size_t i) const { return depth.pixels[i] > 0.0f; }
    const vec3& eyeOf(size_t i) const { return eye.empty() ? image.view.origin : eye.pixels[i]; }
    /// Where rays leave what pixel i sees, on the camera's side.
    SurfaceSide sideAt(const Scene& scene, size_t i) const {
        return sideToward(scene, primitive.pixels[i], position.pixels[i], eyeOf(i));
    }
};

/// What a ray through each pixel's middle sees, through rough glass as if it were smooth: behind
/// all blended surfaces, or, where `veil` is not 0, the so manieth of these. Direct light is black.
GBuffer renderGBuffer(const Tracer& tracer, const Camera& camera, int width, int height,
                      int veil = 0);

/// The same of any places of the image, in pixels, (0.5, 0.5) the first one's middle: packed row by
/// row, `columns` to a row, whose number theirs is a multiple of. `image` of the result has the
/// camera's view and pixel angle, but these rows and columns for a size. Each ray goes elsewhere in
/// what rough glass makes of it, by its place in its pixel: all those of a pixel together are its
/// blur.
GBuffer renderSamples(const Tracer& tracer, const Camera& camera, const ivec2& size,
                      std::span<const vec2> places, int columns, int veil = 0);

/// Boxes of surfaces, each within the next, from what the camera sees nearest to it on to all but
/// the scene's bounds: none where these are hardly larger, as where a room is the scene.
std::vector<Bounds> nearBoxes(const Scene& scene, const GBuffer& gbuffer);

/// Lights what it sees directly, by the shadow maps.
void lightGBuffer(gl::WorkerPool& pool, const GpuScene& gpu, GBuffer& gbuffer);

}  // namespace sheen
