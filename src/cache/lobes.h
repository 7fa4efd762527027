// The specular lobes of the pixels, ready to be multiplied with records.
#pragma once

#include <cstdint>
#include <vector>

#include "cache/classes.h"
#include "image/image.h"
#include "raster/gbuffer.h"
#include "sh/sh.h"

namespace sheen::shared {
using namespace glm;
#include "shared/lobe.glsl"
}  // namespace sheen::shared

namespace sheen {

/// The specular lobe of each glossy pixel in spherical harmonics, world space. One set of
/// coefficients serves the three channels: the lobe's shape is taken at the mean F0, and what a
/// coloured F0 changes of its albedo is a factor.
/// Coefficients are kept as whole LOBE_STEPS-ths of the pixel's greatest: there are up to 100 a
/// pixel to store and upload, and every record that serves it reads them.
struct PixelLobes {
    Image<int> first;  ///< index of a pixel's first coefficient, a multiple of 8; -1: none
    std::vector<int16_t> steps;  ///< [pixel][coefficient], zeros from order^2 to its groups' end
    Image<vec3> scale;           ///< empty where no pixel has a lobe

    /// A pixel's lobe, before its scale.
    shared::ShVector at(int pixel, int order) const;
};
PixelLobes buildLobes(const GBuffer& gbuffer, const PixelClasses& classes);

/// What a pixel's lobe reflects of constant light.
vec3 specularAlbedo(const GBuffer& gbuffer, int pixel);

}  // namespace sheen
