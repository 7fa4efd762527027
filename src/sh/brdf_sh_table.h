// Size and axes of the table that make_brdf_sh.cpp writes and brdf_sh.cpp reads.
#pragma once

#include <algorithm>
#include <cmath>

#include "scene/shared.h"
#include "sh/sh.h"

namespace sheen {

constexpr int kBrdfShMu = 64;
constexpr int kBrdfShRoughness = 40;

/// Continuous sample coordinates, 0..size - 1; samples at the ends. Both axes grow like the square:
/// - the view's angle above the horizon. A smooth surface's lobe changes over angles of about alpha
///   there. Toward the normal, samples are even in the angle, since the lobe's direction follows
///   it. (Even in NoV or its root, the coefficients of m = 1 go like sqrt(1 - NoV) near the normal,
///   which a linear lookup misses by up to a fifth of the lobe's convolution.)
/// - roughness above MIN_ROUGHNESS: at grazing views a smooth surface's lobe follows alpha / NoV.
inline vec2 brdfShCoord(float NoV, float roughness) {
    const float height = std::asin(std::clamp(NoV, 0.0f, 1.0f)) / (0.5f * kPi);
    const float above =
        (std::clamp(roughness, shared::MIN_ROUGHNESS, 1.0f) - shared::MIN_ROUGHNESS) /
        (1.0f - shared::MIN_ROUGHNESS);
    return vec2(std::sqrt(height), std::sqrt(above)) * vec2(kBrdfShMu - 1, kBrdfShRoughness - 1);
}

/// The inverse: NoV and roughness of a sample.
inline vec2 brdfShParams(int x, int y) {
    const vec2 t = vec2(x, y) / vec2(kBrdfShMu - 1, kBrdfShRoughness - 1);
    return {std::sin(0.5f * kPi * t.x * t.x),
            shared::MIN_ROUGHNESS + (1.0f - shared::MIN_ROUGHNESS) * t.y * t.y};
}

}  // namespace sheen
