#include "sh/brdf_sh.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"
#include "sh/brdf_sh_table.h"

namespace sheen {
namespace {

constexpr int kStride = 2 * kShTriangle;

constexpr float kTable[] = {
#include "brdf_sh.inc"
};
static_assert(sizeof(kTable) == sizeof(float) * kStride * kBrdfShMu * kBrdfShRoughness);

// Typical amplitude of indirect light's coefficients in band l, relative to what constant light has
// in band 0: measured on records of the project's scenes (docs/decisions/gather.md).
float lightAmplitude(int l) { return 1.0f / static_cast<float>(l + 1); }

}  // namespace

BrdfShSample brdfSh(float NoV, float roughness) {
    const vec2 coord = brdfShCoord(NoV, roughness);
    const int x = std::min(static_cast<int>(coord.x), kBrdfShMu - 2);
    const int y = std::min(static_cast<int>(coord.y), kBrdfShRoughness - 2);
    const float tx = coord.x - static_cast<float>(x);
    const float ty = coord.y - static_cast<float>(y);
    const float* p00 = kTable + static_cast<size_t>(y * kBrdfShMu + x) * kStride;
    const float* p10 = p00 + kStride;
    const float* p01 = p00 + static_cast<size_t>(kBrdfShMu) * kStride;
    const float* p11 = p01 + kStride;
    const float w00 = (1 - tx) * (1 - ty);
    const float w10 = tx * (1 - ty);
    const float w01 = (1 - tx) * ty;
    const float w11 = tx * ty;
    BrdfShSample sample;
    for (int i = 0; i < kShTriangle; ++i) {
        const int j = i + kShTriangle;
        sample.a[i] = w00 * p00[i] + w10 * p10[i] + w01 * p01[i] + w11 * p11[i];
        sample.b[i] = w00 * p00[j] + w10 * p10[j] + w01 * p01[j] + w11 * p11[j];
    }
    return sample;
}

BrdfRotator::BrdfRotator(int order) : order_(order) {
    SHEEN_CHECK(order >= 1 && order <= shared::SH_MAX_ORDER);
    // Directions evenly spaced over half the plane of incidence: the other half is their antipodes.
    std::vector<shared::ShVector> basis;
    for (int i = 0; i < order; ++i) {
        const float theta = kPi * (static_cast<float>(i) + 0.5f) / static_cast<float>(order);
        axes_.emplace_back(std::sin(theta), std::cos(theta));
        basis.push_back(shared::shBasis({axes_.back().x, 0.0f, axes_.back().y}, order));
    }
    // Band l: find w with sum_i w_i Y_lm(axis_i) = b_m for every m, the smallest such w:
    // w = M^T (M M^T)^-1 b, M [m][direction].
    for (int l = 0; l < order; ++l) {
        const int size = l + 1;
        std::vector<double> gram(static_cast<size_t>(size) * size);
        std::vector<double> m_matrix(static_cast<size_t>(size) * order);
        for (int m = 0; m < size; ++m) {
            for (int i = 0; i < order; ++i) {
                m_matrix[static_cast<size_t>(m) * order + i] =
                    basis[static_cast<size_t>(i)].c[shared::shIndex(l, m)];
            }
        }
        for (int m = 0; m < size; ++m) {
            for (int k = 0; k < size; ++k) {
                for (int i = 0; i < order; ++i) {
                    gram[static_cast<size_t>(m) * size + k] +=
                        m_matrix[static_cast<size_t>(m) * order + i] *
                        m_matrix[static_cast<size_t>(k) * order + i];
                }
            }
        }
        solveSpd(size, gram, m_matrix, order);
        weights_.insert(weights_.end(), m_matrix.begin(), m_matrix.end());
    }
}

void BrdfRotator::rotate(const BrdfShSample& lobe, float f0, float f90, const vec3& n,
                         const vec3& wo, float* coefficients) const {
    const vec3 side = wo - glm::dot(wo, n) * n;
    const float side_length = glm::length(side);
    // Seen along the normal the lobe is symmetric about it, and any tangent will do.
    const vec3 helper = std::abs(n.x) < 0.9f ? vec3(1, 0, 0) : vec3(0, 1, 0);
    const vec3 t =
        side_length > 1e-5f ? side / side_length : glm::normalize(helper - glm::dot(helper, n) * n);
    // [l][direction]: weights of the zonal harmonics.
    float zonal[shared::SH_MAX_ORDER][shared::SH_MAX_ORDER] = {};
    const float* weights = weights_.data();
    for (int l = 0; l < order_; ++l) {
        for (int m = 0; m <= l; ++m, weights += order_) {
            const int entry = shTriangleIndex(l, m);
            const float b = f0 * lobe.a[entry] + f90 * lobe.b[entry];
            for (int i = 0; i < order_; ++i) {
                zonal[l][i] += weights[i] * b;
            }
        }
    }
    std::fill(coefficients, coefficients + order_ * order_, 0.0f);
    for (int i = 0; i < order_; ++i) {
        const vec2& axis = axes_[static_cast<size_t>(i)];
        const shared::ShVector y = shared::shBasis(axis.x * t + axis.y * n, order_);
        for (int l = 0; l < order_; ++l) {
            for (int j = l * l; j < (l + 1) * (l + 1); ++j) {
                coefficients[j] += zonal[l][i] * y.c[j];
            }
        }
    }
}

LobePrediction predictLobeError(float NoV, float roughness) {
    const BrdfShSample lobe = brdfSh(NoV, roughness);
    // Relative to the response to constant light of the same mean: b_0 against itself.
    const float b0 = std::max(lobe.a[0], 1e-12f);
    float band_error[shared::SH_MAX_ORDER];
    float share[shared::SH_MAX_ORDER];  // of what a mirror has in band l: 2 l + 1
    float diffuse_error = 0.0f;
    for (int l = 0; l < shared::SH_MAX_ORDER; ++l) {
        // Coefficients of a cosine lobe with the same albedo: bands of max(z, 0) are zonal.
        // [RH01, eq. 19]
        const float cosine_band[] = {1.0f, 1.1547005f, 0.5590170f, 0.0f,        -0.125f,
                                     0.0f, 0.0563367f, 0.0f,       -0.0322118f, 0.0f};
        float power = 0.0f;
        float difference = 0.0f;
        for (int m = 0; m <= l; ++m) {
            const float b = lobe.a[shTriangleIndex(l, m)] / b0;
            const float cosine = m == 0 ? cosine_band[l] : 0.0f;
            power += b * b;
            difference += (b - cosine) * (b - cosine);
        }
        const float s = lightAmplitude(l);
        band_error[l] = s * s * power;
        share[l] = power / static_cast<float>(2 * l + 1);
        diffuse_error += s * s * difference;
    }
    LobePrediction prediction{};
    prediction.as_diffuse = std::sqrt(diffuse_error);
    // Beyond the table a lobe's share of a mirror falls on exponentially, as fast as over its last
    // bands.
    constexpr int kLast = shared::SH_MAX_ORDER - 1;
    constexpr int kFitted = 3;
    constexpr int kBands = 400;
    const float fall =
        std::pow(std::clamp(share[kLast] / std::max(share[kLast - kFitted], 1e-12f), 0.0f, 1.0f),
                 1.0f / kFitted);
    float tail = 0.0f;
    float beyond = share[kLast];
    for (int l = shared::SH_MAX_ORDER; l < kBands; ++l) {
        beyond *= fall;
        const float s = lightAmplitude(l);
        tail += s * s * beyond * static_cast<float>(2 * l + 1);
    }
    prediction.truncated[shared::SH_MAX_ORDER] = std::sqrt(tail);
    for (int n = shared::SH_MAX_ORDER - 1; n >= 0; --n) {
        tail += band_error[n];
        prediction.truncated[n] = std::sqrt(tail);
    }
    return prediction;
}

}  // namespace sheen
