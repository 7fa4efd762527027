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

mat3 tangentFrame(const vec3& n, float angle) {
    const mat3 frame = tangentFrame(n);
    const float c = std::cos(angle);
    const float s = std::sin(angle);
    return {c * frame[0] + s * frame[1], c * frame[1] - s * frame[0], n};
}

vec3 convolveRecord(const Record& k, const float* sh, const float* lobe, int order, const vec3& p) {
    const ShLayout layout = shLayout(k.order);
    const vec3 d = p - k.position;
    const float along[2] = {glm::dot(d, k.tangent), glm::dot(d, glm::cross(k.normal, k.tangent))};
    vec3 sum(0.0f);
    for (int i = 0; i < order * order; ++i) {
        for (int c = 0; c < 3; ++c) {
            float value = sh[c * layout.coefficients() + i];
            for (int axis = 0; axis < 2 && i < layout.gradientCoefficients(); ++axis) {
                value += along[axis] *
                         sh[layout.gradientFirst(axis) + c * layout.gradientCoefficients() + i];
            }
            sum[c] += lobe[i] * value;
        }
    }
    return sum;
}

}  // namespace sheen
