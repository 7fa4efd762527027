// The independent judge: a path tracer that computes what the cache approximates, with the variance
// of its own answer. It shares only the scene and the BRDF with the rest.
//
// At the point p of each pixel's centre, or on average over the points that its area sees,
//   direct(p)   = sum over punctual lights of f cos * irradiance * visibility
//                 + integral over lamps of f cos Le,
//   indirect(p) = integral over the hemisphere of the shading normal of f cos [direct(q) + sky(q)],
//                 q: the first surface seen in that direction; where there is none, of f cos sky;
//                 sky(q): what of the sky's light q scatters.
//   caustic(p)  = of indirect(p), the paths on which all surfaces between p and the light scatter
//   by
//                 specular lobes, and p does not: it is taken out there where it is wanted apart.
// More bounces continue the path from q to a fixed depth or, for all of them, until it ends by
// Russian roulette. Lamps are the triangles that emit. Their
// light and the sky's is estimated twice at each vertex, by directions toward them and by those of
// the BRDF, weighed against each other.
// Based on: [Kaj86], [VG95], sampled by lights.h and sampling.h at the points of sobol.h, which
// guide.h warps.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>

#include "core/bounces.h"
#include "image/frame.h"
#include "reference/ray_scene.h"
#include "scene/scene.h"

namespace sheen {

struct ReferenceParams {
    int width = 512;
    int height = 512;
    Camera camera;
    /// 1: exactly the integral above; 0: no indirect light; kAllBounces: paths end by chance alone
    int bounces = kAllBounces;
    /// Gather paths a pixel; rounded up to a multiple of `replicates`. Powers of two a replicate
    /// are stratified best. From 256 on, at most as many paths come on top that only teach the
    /// guide where light comes from (256; from 1024 on 1024; from 4096 on 4096).
    int spp = 256;
    int replicates = 16;  ///< independent estimates the variance is taken from, at least 2
    /// Light is that of the pixel's whole area, by paths from everywhere in it, instead of its
    /// middle's; the G-buffer stays that of the middle.
    bool pixel_area = false;
    /// What specular surfaces alone make of lights is a layer of its own, where there are any;
    /// else it is part of the indirect light.
    bool caustics_apart = false;
    uint32_t seed = 0;
    bool quiet = false;  ///< no progress
};

struct ReferenceResult {
    /// All layers but the cache's. Variances are of the mean, [pixel], per channel, in nits^2;
    /// that of `direct` is of lamps alone, unless a pixel's area is: punctual lights are not
    /// sampled.
    Frame frame;
    Image<vec3> specular_albedo;    ///< of the specular lobe toward the camera
    double mrays_per_second = 0.0;  ///< camera, gather and shadow rays, in millions
    double seconds = 0.0;           ///< wall clock, building the acceleration structure included
    int spp = 0;                    ///< paths a pixel after rounding
    int64_t rays = 0;
    int64_t nonfinite_samples = 0;  ///< paths dropped because their radiance was not finite
};

/// Renders the reference. The same bits for any number of threads. Usage error for a size, number
/// of samples or bounces out of range; environment error where Embree fails.
ReferenceResult renderReference(const Scene& scene, const ReferenceParams& params);

/// The surface whose light is wanted at place (x, y) of an image's rows; none where there is none.
using SurfaceOf = std::function<std::optional<Surface>(int x, int y)>;

/// The same of surfaces of one's own instead of what a camera sees, which is not asked: layers of
/// direct and indirect light and their variances, and nothing else.
ReferenceResult renderReferenceOf(const Scene& scene, const ReferenceParams& params,
                                  const SurfaceOf& surface_of);

}  // namespace sheen
