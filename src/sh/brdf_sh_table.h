// Size and axes of the table that make_brdf_sh.cpp writes and brdf_sh.cpp reads.
#pragma once

#include <cmath>

#include "sh/sh.h"

namespace sheen {

constexpr int kBrdfShMu = 32;
constexpr int kBrdfShRoughness = 24;

/// NoV and roughness of a sample: evenly spaced view *angles*, since the lobe's direction follows
/// the angle. (Even in NoV or its root, the coefficients of m = 1 go like sqrt(1 - NoV) near the
/// normal, which a linear lookup misses by up to a fifth of the lobe's convolution.)
inline vec2 brdfShParams(int x, int y) {
    const float angle = 0.5f * kPi * static_cast<float>(x) / (kBrdfShMu - 1);
    return {std::cos(angle), static_cast<float>(y) / (kBrdfShRoughness - 1)};
}

}  // namespace sheen
