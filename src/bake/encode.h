// What is baked as the image that a .glb file holds.
#pragma once

#include <string>

#include "bake/bake.h"

namespace sheen {

/// A PNG image's bytes, and what 1 in it stands for.
struct EncodedLight {
    std::string png;
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

}  // namespace sheen
