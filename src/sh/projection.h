// From the texels of a hemisphere to spherical harmonics: a constant matrix.
#pragma once

#include <vector>

#include "hemisphere/hemisphere.h"
#include "sh/sh.h"

namespace sheen {

/// Least-squares fit over the upper hemisphere plus a band below the horizon whose target is the
/// horizon's radiance at the same azimuth, so that a pixel whose normal tilts against its record's
/// still reads something sane there.
struct ProjectionParams {
    int order = 4;
    float band_degrees = 30.0f;  ///< how far the band reaches below the horizon
    float band_weight = 0.1f;
    float ridge = 1e-4f;  ///< on bands l > 0 only: constant light is reproduced exactly
};

/// Coefficients [coefficient][texel] in the record's local frame: c = matrix * radiance.
std::vector<float> projectionMatrix(const Hemisphere& hemisphere, const ProjectionParams& params);

/// The same of light that comes from the hemisphere and from nowhere below it: each texel's
/// radiance times the integral of the basis over it. Those of two opposite hemispheres add up to
/// those of the whole sphere. Constant light is projected exactly; of hemispheres whose texels
/// cover all of it.
std::vector<float> integralMatrix(const Hemisphere& hemisphere, int order);

}  // namespace sheen
