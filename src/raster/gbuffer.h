// What the camera sees, per pixel: the input of placement, splatting and composition. Rays find it,
// so that pixels, records and the rays of both see one and the same surface: a rasteriser picks
// another triangle in a pixel of a thousand.
#pragma once

#include "gl/worker_pool.h"
#include "image/image.h"
#include "raster/gpu_scene.h"
#include "rays/surface_point.h"
#include "rays/tracer.h"

namespace sheen {

/// Row 0 on top. Pixels without geometry have depth 0 and triangle kNoPrimitive.
struct GBuffer {
    int width = 0;
    int height = 0;
    View view;
    Image<vec4> position;  ///< world space; w: depth along the view axis
    Image<vec4> normal;    ///< shading normal, world space; w: perceptual roughness
    /// By normal maps, for direct light; empty where no material has one. Records stand on, and
    /// serve, the smooth surface.
    Image<vec3> mapped_normal;
    Image<vec4> diffuse;   ///< diffuse reflectance toward the camera; w: F90
    Image<vec3> f0;        ///< specular F0
    Image<vec3> direct;    ///< radiance of direct light
    Image<vec3> emission;  ///< radiance; empty where no material emits and no sky shows
    Image<uint32_t> primitive;
    float pixel_angle = 0;  ///< width of a pixel at depth 1

    /// By which direct light is scattered.
    vec3 mappedNormalAt(size_t pixel) const {
        return mapped_normal.empty() ? vec3(normal.pixels[pixel]) : mapped_normal.pixels[pixel];
    }
    bool seen(int i) const { return position.pixels[static_cast<size_t>(i)].w > 0.0f; }
    /// What pixel i is wide at the distance of what it sees, in scene units.
    float footprintAt(int i) const {
        return position.pixels[static_cast<size_t>(i)].w * pixel_angle;
    }
    /// Unit, of the triangle that pixel i sees, on the camera's side.
    vec3 geometricNormalAt(const Scene& scene, int i) const;
    /// Where a ray that leaves what pixel i sees starts, and on which side, as offSurface() has it.
    SurfaceSide sideAt(const Scene& scene, int i) const;
};

/// What a ray through each pixel's middle meets first. Direct light is black.
GBuffer renderGBuffer(const Tracer& tracer, const Camera& camera, int width, int height);

/// Boxes of surfaces, each within the next, from what the camera sees nearest to it on to all but
/// the scene's bounds: none where these are hardly larger, as where a room is the scene.
std::vector<Bounds> nearBoxes(const Scene& scene, const GBuffer& gbuffer);

/// Lights what it sees directly, by the shadow maps.
void lightGBuffer(gl::WorkerPool& pool, const GpuScene& gpu, GBuffer& gbuffer);

}  // namespace sheen
