#include "cache/record.h"

#include <cmath>

namespace sheen {

mat3 tangentFrame(const vec3& n) {
    const float sign = std::copysign(1.0f, n.z);
    const float a = -1.0f / (sign + n.z);
    const float b = n.x * n.y * a;
    return {vec3(1.0f + sign * n.x * n.x * a, sign * b, -sign * n.x),
            vec3(b, sign + n.y * n.y * a, -n.y), n};
}

}  // namespace sheen
