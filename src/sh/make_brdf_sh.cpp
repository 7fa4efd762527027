// Build-time generator of the BRDF's spherical harmonics: b_lm = integral of lobe * cosine * Y_lm
// over incoming directions, by sampling visible normals, where the estimator is F * G2 / G1 * Y_lm.
#include <fmt/format.h>

#include <cstdint>

#include "scene/ggx_sampling.h"
#include "scene/shared.h"
#include "sh/brdf_sh_table.h"

namespace {

constexpr int kSide = 64;  // stratified samples along a side

}  // namespace

int main() {
    using namespace sheen;
    for (int y = 0; y < kBrdfShRoughness; ++y) {
        for (int x = 0; x < kBrdfShMu; ++x) {
            const vec2 params = brdfShParams(x, y);
            const float mu = std::max(params.x, shared::MIN_COSINE);
            const float alpha = shared::alphaFromRoughness(params.y);
            const vec3 wo(std::sqrt(1.0f - mu * mu), 0.0f, mu);
            double sums[2][kShTriangle] = {};
            for (int i = 0; i < kSide * kSide; ++i) {
                const vec2 u((static_cast<float>(i % kSide) + 0.5f) / kSide,
                             (static_cast<float>(i / kSide) + 0.5f) / kSide);
                const vec3 h = sampleGgxVisibleNormal(wo, alpha, u);
                const float VoH = glm::dot(wo, h);
                const vec3 wi = 2.0f * VoH * h - wo;
                if (wi.z <= 0.0f || VoH <= 0.0f) {
                    continue;
                }
                const float g2 = 4.0f * wi.z * mu * shared::visibilitySmith(mu, wi.z, alpha);
                const double weight = g2 / maskingSmith(mu, alpha) / (kSide * kSide);
                const double f = shared::schlickWeight(VoH);
                const shared::ShVector basis =
                    shared::shBasis(glm::normalize(wi), shared::SH_MAX_ORDER);
                for (int l = 0; l < shared::SH_MAX_ORDER; ++l) {
                    for (int m = 0; m <= l; ++m) {
                        const double value = weight * basis.c[shared::shIndex(l, m)];
                        sums[0][shTriangleIndex(l, m)] += (1.0 - f) * value;
                        sums[1][shTriangleIndex(l, m)] += f * value;
                    }
                }
            }
            for (const auto& row : sums) {
                for (double value : row) {
                    fmt::print("{:.5e}f,", value);
                }
            }
            fmt::print("\n");
        }
    }
    return 0;
}
