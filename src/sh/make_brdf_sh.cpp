// Build-time generator of the BRDF's spherical harmonics: b_lm = integral of lobe * cosine * Y_lm
// over incoming directions, by sampling visible normals, where the estimator is F * G2 / G1 * Y_lm.
#include <fmt/format.h>

#include <cstdint>

#include "scene/ggx_sampling.h"
#include "scene/shared.h"
#include "sh/brdf_sh_table.h"

namespace {

// Sampled directions of the hemisphere that visible normals are warped from.
constexpr int kPolar = 64;
constexpr int kAzimuths = 32;  // evenly spaced, as suits a periodic integrand of ten bands

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
            for (int i = 0; i < kPolar * kAzimuths; ++i) {
                // Even steps of the polar angle. u.x is its squared sine, and even steps of that
                // jump the rim, where the steepest normals come from.
                const float polar =
                    0.5f * kPi * (static_cast<float>(i / kAzimuths) + 0.5f) / kPolar;
                const float du = 0.5f * kPi * std::sin(2.0f * polar);  // u.x per even step
                const vec2 u(std::sin(polar) * std::sin(polar),
                             (static_cast<float>(i % kAzimuths) + 0.5f) / kAzimuths);
                const vec3 h = sampleGgxVisibleNormal(wo, alpha, u);
                const float VoH = glm::dot(wo, h);
                const vec3 wi = 2.0f * VoH * h - wo;
                if (wi.z <= 0.0f || VoH <= 0.0f) {
                    continue;
                }
                const double weight =
                    du * visibleNormalWeight(mu, wi.z, alpha) / (kPolar * kAzimuths);
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
