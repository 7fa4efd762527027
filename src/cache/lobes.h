// The specular lobes of the pixels, ready to be multiplied with records.
#pragma once

#include <vector>

#include "cache/classes.h"
#include "image/image.h"
#include "raster/gbuffer.h"

namespace sheen {

/// The specular lobe of each glossy pixel in spherical harmonics, world space. One set of
/// coefficients serves the three channels: the lobe's shape is taken at the mean F0, and what a
/// coloured F0 changes of its albedo is a factor.
struct PixelLobes {
    Image<int> first;                 ///< index of a pixel's first coefficient, -1: none
    std::vector<float> coefficients;  ///< as many a pixel as the square of its order
    Image<vec3> scale;
};
PixelLobes buildLobes(const GBuffer& gbuffer, const PixelClasses& classes);

}  // namespace sheen
