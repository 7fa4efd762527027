// What a hint keeps of the light that arrives at it, and what that says.
#pragma once

#include "core/math.h"

namespace sheen {

/// So many directions of the axes, each of which has a residual.
constexpr int kHintAxes = 6;

/// Numbers of a hint by spherical harmonics of that order: coefficients of radiance
/// [coefficient][channel], then, for +x -x +y -y +z -z, [axis][channel] what these miss of the
/// irradiance. All of it is linear in the light.
/// So few bands see light from below the horizon: of a bright floor a sixteenth of its light would
/// come back to itself. The residuals make irradiance along the axes exact; others have them by the
/// squares of the normal.
constexpr int hintNumbers(int order) { return 3 * (order * order + kHintAxes); }
constexpr int kMostHintNumbers = hintNumbers(3);

/// Adds light from a unit direction, radiance times solid angle. Until keepMissed() the residuals
/// are the irradiance itself.
void addHintLight(const vec3& direction, const vec3& light, int order, float* sums);

/// Ends the adding of light.
void keepMissed(int order, float* sums);

/// On a surface of unit normal n; not negative.
vec3 hintIrradiance(const float* numbers, const vec3& n, int order);

/// Radiance as a lobe of these coefficients sees it, mean over the lobe; not negative. A lobe that
/// is narrower than the bands tell would ring: it is taken as wide as a cosine.
vec3 hintThroughLobe(const float* numbers, const float* lobe, int order);

}  // namespace sheen
