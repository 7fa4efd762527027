// Specular light of pixels whose lobes spherical harmonics do not follow: rays of their own correct
// what their records say or, where they are too glossy for the cache, say all of it. Pixels share
// what their rays saw.
#pragma once

#include "cache/classes.h"
#include "image/image.h"
#include "raster/gbuffer.h"
#include "rays/light_cells.h"
#include "rays/ray_caster.h"

namespace sheen {

/// Defaults were chosen by measurement (docs/decisions.md).
struct SpecularParams {
    float rays_per_alpha = 1920;  ///< a pixel's rays by its lobe's width, in whole packets
    int max_rays = 192;           ///< a pixel
    int window = 6;               ///< pixels farther away share no rays, in x or y; 0: none do
    /// Nor, where rays say all, lobes whose axes are microfacet slopes of so many alpha apart.
    float overlap = 0.25f;
};

/// What the lobe of a pixel sees by rays of its own.
struct SpecularSeen {
    vec3 light{};        ///< the lobe's mean of what arrives: one for constant light of one
    float nearness = 0;  ///< mean of one over the distance it comes from; 0: no ray met anything
    vec3 mirrored{};     ///< where it comes from: the direction that mirrors the viewer's
};

/// What the lobes of the pixels in PixelClasses::by_rays see of indirect light. Rays follow the
/// lobe (visible normals [Hei18]) at random places; they see light scattered once, as a record
/// does. `cells`: may be null.
Image<SpecularSeen> traceSpecular(const RayCaster& rays, const LightCells* cells,
                                  const GBuffer& gbuffer, const PixelClasses& classes,
                                  const SpecularParams& params);

/// What these lobes reflect; black elsewhere. `cached`: by the records alone, as cachedSpecular()
/// finds it, black where pixels are too glossy for the cache. To that of a corrected pixel the mean
/// is added of what the rays see more than the records around it; too glossy ones take the mean of
/// what those see whose lobes overlap.
Image<vec3> reflectSpecular(const Scene& scene, const GBuffer& gbuffer, const PixelClasses& classes,
                            const Image<SpecularSeen>& seen, const Image<vec3>& cached,
                            const SpecularParams& params);

}  // namespace sheen
