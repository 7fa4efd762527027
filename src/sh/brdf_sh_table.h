// Size and axes of the table that make_brdf_sh.cpp writes and brdf_sh.cpp reads.
#pragma once

#include "sh/sh.h"

namespace sheen {

constexpr int kBrdfShMu = 32;
constexpr int kBrdfShRoughness = 24;

/// NoV and roughness of a sample: square-root spacing in NoV, where grazing views change fastest.
inline vec2 brdfShParams(int x, int y) {
    const float root_mu = static_cast<float>(x) / (kBrdfShMu - 1);
    return {root_mu * root_mu, static_cast<float>(y) / (kBrdfShRoughness - 1)};
}

}  // namespace sheen
