// What is baked as the image that a .glb file holds.
#pragma once

#include <string>
#include <vector>

#include "bake/bake.h"
#include "scene/lightmap_file.h"

namespace sheen {

/// PNG images' bytes, one a page, and what 1 in them stands for.
struct EncodedLight {
    std::vector<std::string> pngs;
    float intensity = 1.0f;
};

/// Irradiance, linear, in 8 bits a channel. What is brighter than `intensity` is clipped: that is
/// chosen for the least sum of squared errors by clipping and rounding over the texels that have
/// light of their own.
EncodedLight encodeIrradiance(const Lightmap& map, const Image<vec3>& irradiance);

/// What the surfaces send out by it, as sRGB colours for unlit materials, exposed as a PNG of a
/// render is and clipped; what they and their coats would mirror is spread over all directions.
/// Alpha is that of the material.
EncodedLight encodeUnlit(const Scene& scene, const Lightmap& map, const Image<vec3>& irradiance);

/// Where a scene's triangles lie in its file, which has no images yet: `source` as it was loaded.
LightmapFile lightmapFileOf(const std::string& source, const Atlas& atlas);

}  // namespace sheen
