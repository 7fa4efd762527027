#include "scene/brdf_albedo.h"

#include <algorithm>

#include "scene/shared.h"

namespace sheen {
namespace {

constexpr int kWidth = shared::ALBEDO_TABLE_MU;
constexpr int kHeight = shared::ALBEDO_TABLE_ROUGHNESS;

constexpr float kTable[] = {
#include "brdf_albedo.inc"
};
static_assert(sizeof(kTable) == sizeof(float) * 2 * kWidth * kHeight);

vec2 sample(int x, int y) {
    const float* p = kTable + 2 * (y * kWidth + x);
    return {p[0], p[1]};
}

}  // namespace

const float* brdfAlbedoTable() { return kTable; }

vec2 brdfAlbedo(float NoV, float roughness) {
    const vec2 coord = shared::albedoTableCoord(NoV, roughness);
    // In this order a NaN finds a cell, too, and stays a NaN.
    const int x = static_cast<int>(std::min(kWidth - 2.0f, coord.x));
    const int y = static_cast<int>(std::min(kHeight - 2.0f, coord.y));
    const vec2 f = coord - vec2(x, y);
    const vec2 lower = glm::mix(sample(x, y), sample(x + 1, y), f.x);
    const vec2 upper = glm::mix(sample(x, y + 1), sample(x + 1, y + 1), f.x);
    return glm::mix(lower, upper, f.y);
}

}  // namespace sheen
