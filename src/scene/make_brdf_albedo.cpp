// Build-time generator: integrates the specular lobe's directional albedo by sampling visible
// normals, where the estimator is F * G2 / G1, and prints the table as C++ initialisers.
#include <fmt/format.h>

#include <cstdint>

#include "scene/ggx_sampling.h"
#include "scene/shared.h"

namespace {

constexpr int kSamples = 4096;

// Second coordinate of the Hammersley point set.
float radicalInverse(uint32_t i) {
    i = (i << 16) | (i >> 16);
    i = ((i & 0x00ff00ffu) << 8) | ((i & 0xff00ff00u) >> 8);
    i = ((i & 0x0f0f0f0fu) << 4) | ((i & 0xf0f0f0f0u) >> 4);
    i = ((i & 0x33333333u) << 2) | ((i & 0xccccccccu) >> 2);
    i = ((i & 0x55555555u) << 1) | ((i & 0xaaaaaaaau) >> 1);
    return static_cast<float>(i) * 2.3283064365386963e-10f;
}

}  // namespace

int main() {
    using namespace sheen;
    for (int y = 0; y < shared::ALBEDO_TABLE_ROUGHNESS; ++y) {
        for (int x = 0; x < shared::ALBEDO_TABLE_MU; ++x) {
            const vec2 params = shared::albedoTableParams(x, y);
            const float mu = std::max(params.x, shared::MIN_COSINE);
            const float alpha = shared::alphaFromRoughness(params.y);
            const vec3 wo(std::sqrt(1.0f - mu * mu), 0.0f, mu);
            double a = 0.0;
            double b = 0.0;
            for (int i = 0; i < kSamples; ++i) {
                const vec2 u((static_cast<float>(i) + 0.5f) / kSamples,
                             radicalInverse(static_cast<uint32_t>(i)));
                const vec3 h = sampleGgxVisibleNormal(wo, alpha, u);
                const float VoH = glm::dot(wo, h);
                const float NoL = 2.0f * VoH * h.z - wo.z;
                if (NoL <= 0.0f || VoH <= 0.0f) {
                    continue;
                }
                const double weight = visibleNormalWeight(mu, NoL, alpha);
                const double f = shared::schlickWeight(VoH);
                a += (1.0 - f) * weight;
                b += f * weight;
            }
            fmt::print("{:.6e}f,{:.6e}f,\n", a / kSamples, b / kSamples);
        }
    }
    return 0;
}
