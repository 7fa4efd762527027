// Specular light of pixels too glossy for the cache: gathered at each of them by rays, which
// pixels whose lobes overlap share.
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
    float overlap = 0.25f;  ///< nor lobes whose axes are microfacet slopes of so many alpha apart
};

/// What the specular lobe of every pixel in PixelClasses::by_rays reflects of indirect light; black
/// elsewhere. Rays follow the lobe (visible normals [Hei18]) at random places; they see light
/// scattered once, as a record does. `cells`: may be null.
Image<vec3> gatherSpecular(const RayCaster& rays, const LightCells* cells, const GBuffer& gbuffer,
                           const PixelClasses& classes, const SpecularParams& params);

}  // namespace sheen
