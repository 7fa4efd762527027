#include "record/record.h"

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

void boundGradients(Record& record, float* sh, float reach, float limit) {
    vec3* translation[] = {&record.translation_r, &record.translation_g, &record.translation_b};
    const ShLayout layout = shLayout(record.order);
    for (int c = 0; c < 3; ++c) {
        const float change = glm::length(*translation[c]) * reach;
        const float most = limit * record.irradiance[c];
        if (change > most) {
            *translation[c] *= most / change;
        }
        if (record.order == shared::DIFFUSE_ORDER) {
            continue;
        }
        float* first[2];
        for (int axis = 0; axis < 2; ++axis) {
            first[axis] = sh + layout.gradientFirst(axis) + c * layout.gradientCoefficients();
        }
        const float value = sh[c * layout.coefficients()];
        const float sh_change = std::hypot(*first[0], *first[1]) * reach;
        const float sh_most = limit * std::max(value, 0.0f);
        const float scale = sh_change > sh_most ? sh_most / sh_change : 1.0f;
        for (int axis = 0; axis < 2; ++axis) {
            for (int k = 0; k < layout.gradientCoefficients(); ++k) {
                first[axis][k] *= scale;
            }
        }
    }
}

}  // namespace sheen
