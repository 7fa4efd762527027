// Specular light of pixels too glossy for the cache: gathered at each of them by rays.
#pragma once

#include "cache/classes.h"
#include "image/image.h"
#include "raster/gbuffer.h"
#include "rays/ray_caster.h"

namespace sheen {

/// What the specular lobe of every pixel in PixelClasses::by_rays reflects of indirect light; black
/// elsewhere. Rays follow the lobe (visible normals [Hei18]) at random places, the fewer the
/// narrower it is; they see light scattered once, as a record does.
Image<vec3> gatherSpecular(const RayCaster& rays, const Scene& scene, const GBuffer& gbuffer,
                           const PixelClasses& classes);

}  // namespace sheen
