// Directions spread evenly over the sphere.
#pragma once

#include <cmath>
#include <vector>

#include "core/math.h"

namespace sheen {

/// `count` unit directions along a spiral about z, each of which stands for the same solid angle.
/// [SP06]
inline std::vector<vec3> evenDirections(int count) {
    std::vector<vec3> directions;
    const double golden = kPi * (3.0 - std::sqrt(5.0));
    for (int i = 0; i < count; ++i) {
        const double z = 1.0 - (2.0 * i + 1.0) / count;
        const double r = std::sqrt(1.0 - z * z);
        directions.emplace_back(r * std::cos(golden * i), r * std::sin(golden * i), z);
    }
    return directions;
}

}  // namespace sheen
