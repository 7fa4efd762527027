// Directions about an axis.
#pragma once

#include <cmath>

#include "core/math.h"

namespace sheen {

/// A tangent frame (tangent, bitangent, normal) that depends on the unit normal alone. [DBC17]
inline mat3 tangentFrame(const vec3& n) {
    const float sign = std::copysign(1.0f, n.z);
    const float a = -1.0f / (sign + n.z);
    const float b = n.x * n.y * a;
    return {vec3(1.0f + sign * n.x * n.x * a, sign * b, -sign * n.x),
            vec3(b, sign + n.y * n.y * a, -n.y), n};
}

/// A direction about +z by u in [0, 1)^2, as dense as its cosine over pi.
inline vec3 cosineDirection(const vec2& u) {
    const float radius = std::sqrt(u.x);
    const float phi = 2.0f * kPi * u.y;
    return {radius * std::cos(phi), radius * std::sin(phi), std::sqrt(std::max(1.0f - u.x, 0.0f))};
}

}  // namespace sheen
