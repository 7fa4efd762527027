#include "hints/hint_light.h"

#include <cmath>

#include "sh/sh.h"

namespace sheen {
namespace {

// What of each band is left of light seen through a cosine. [RH01]
constexpr float kCosineBand[3] = {kPi, 2.0f * kPi / 3.0f, kPi / 4.0f};

// Of a band l, factor times what the numbers say.
template <class Factor>
vec3 weighed(const float* numbers, int order, const Factor& factor) {
    vec3 sum(0.0f);
    for (int l = 0; l < order; ++l) {
        for (int j = l * l; j < (l + 1) * (l + 1); ++j) {
            sum += factor(l, j) * vec3(numbers[3 * j], numbers[3 * j + 1], numbers[3 * j + 2]);
        }
    }
    return sum;
}

vec3 bandsIrradiance(const float* numbers, const vec3& n, int order) {
    const shared::ShVector y = shared::shBasis(n, order);
    return weighed(numbers, order, [&](int l, int j) { return kCosineBand[l] * y.c[j]; });
}

// The residual of the axis that n points along.
int residualOf(int axis, const vec3& n, int order) {
    return 3 * (order * order + 2 * axis + (n[axis] < 0.0f ? 1 : 0));
}

}  // namespace

void addHintLight(const vec3& direction, const vec3& light, int order, float* sums) {
    const shared::ShVector y = shared::shBasis(direction, order);
    for (int j = 0; j < order * order; ++j) {
        for (int c = 0; c < 3; ++c) {
            sums[3 * j + c] += y.c[j] * light[c];
        }
    }
    for (int axis = 0; axis < 3; ++axis) {
        float* toward = sums + residualOf(axis, direction, order);
        for (int c = 0; c < 3; ++c) {
            toward[c] += std::abs(direction[axis]) * light[c];
        }
    }
}

void keepMissed(int order, float* sums) {
    for (int k = 0; k < kHintAxes; ++k) {
        vec3 axis(0.0f);
        axis[k / 2] = k % 2 == 0 ? 1.0f : -1.0f;
        const vec3 said = bandsIrradiance(sums, axis, order);
        float* residual = sums + residualOf(k / 2, axis, order);
        for (int c = 0; c < 3; ++c) {
            residual[c] -= said[c];
        }
    }
}

vec3 hintIrradiance(const float* numbers, const vec3& n, int order) {
    vec3 sum = bandsIrradiance(numbers, n, order);
    for (int axis = 0; axis < 3; ++axis) {
        const float* residual = numbers + residualOf(axis, n, order);
        sum += n[axis] * n[axis] * vec3(residual[0], residual[1], residual[2]);
    }
    return glm::max(sum, vec3(0.0f));
}

vec3 hintThroughLobe(const float* numbers, const float* lobe, int order) {
    if (!(lobe[0] > 0.0f)) {
        return vec3(0.0f);
    }
    float factors[3] = {1.0f, 1.0f, 1.0f};
    for (int l = 1; l < order; ++l) {
        float norm2 = 0.0f;
        for (int j = l * l; j < (l + 1) * (l + 1); ++j) {
            norm2 += lobe[j] * lobe[j];
        }
        const float most = lobe[0] * kCosineBand[l] / kCosineBand[0];
        const float norm = std::sqrt(norm2 / static_cast<float>(2 * l + 1));
        factors[l] = norm > most ? most / norm : 1.0f;
    }
    const vec3 sum = weighed(numbers, order, [&](int l, int j) { return factors[l] * lobe[j]; });
    return glm::max(sum / (lobe[0] * std::sqrt(4.0f * kPi)), vec3(0.0f));
}

}  // namespace sheen
