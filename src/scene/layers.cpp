#include "scene/layers.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "scene/brdf_albedo.h"

namespace sheen {
namespace {

constexpr float kCoatF0 = 0.04f;

// Albedo of fibres by the midpoint rule over directions, [roughness][NoV], both at their samples'
// ends.
class FibreTable {
  public:
    FibreTable() {
        for (int y = 0; y < kSize; ++y) {
            for (int x = 0; x < kSize; ++x) {
                entries_[static_cast<size_t>(y)][static_cast<size_t>(x)] =
                    integrate(static_cast<float>(x) / (kSize - 1),
                              std::max(static_cast<float>(y) / (kSize - 1), kSmoothest));
            }
        }
    }
    float at(float NoV, float roughness) const {
        const float x = std::clamp(NoV, 0.0f, 1.0f) * (kSize - 1);
        const float y = std::clamp(roughness, 0.0f, 1.0f) * (kSize - 1);
        const size_t i = static_cast<size_t>(std::min(x, kSize - 2.0f));
        const size_t j = static_cast<size_t>(std::min(y, kSize - 2.0f));
        const float u = x - static_cast<float>(i);
        const float v = y - static_cast<float>(j);
        return glm::mix(glm::mix(entries_[j][i], entries_[j][i + 1], u),
                        glm::mix(entries_[j + 1][i], entries_[j + 1][i + 1], u), v);
    }

  private:
    static constexpr int kSize = 32;
    static constexpr float kSmoothest = 0.07f;

    static float integrate(float mu, float roughness) {
        constexpr int kCosines = 64;
        constexpr int kAzimuths = 32;
        const float power = 1.0f / (roughness * roughness);
        const vec3 wo(std::sqrt(1.0f - mu * mu), 0.0f, mu);
        float sum = 0.0f;
        for (int i = 0; i < kCosines; ++i) {
            const float NoL = (static_cast<float>(i) + 0.5f) / kCosines;
            for (int j = 0; j < kAzimuths; ++j) {
                const float phi = kPi * (static_cast<float>(j) + 0.5f) / kAzimuths;
                const float s = std::sqrt(1.0f - NoL * NoL);
                const vec3 h = glm::normalize(wo + vec3(s * std::cos(phi), s * std::sin(phi), NoL));
                const float sin2 = std::max(1.0f - h.z * h.z, 0.0f);
                const float distribution =
                    (2.0f + power) * std::pow(sin2, 0.5f * power) / (2.0f * kPi);
                const float visibility =
                    1.0f / (4.0f * std::max(NoL + mu - NoL * mu, shared::MIN_COSINE));
                sum += distribution * visibility * NoL;
            }
        }
        return std::min(sum * 2.0f * kPi / (kCosines * kAzimuths), 1.0f);
    }

    std::array<std::array<float, kSize>, kSize> entries_;
};

}  // namespace

shared::Brdf coatBrdf(const Layers& layers) {
    return {.diffuse = vec3(0.0f),
            .alpha = shared::alphaFromRoughness(layers.coat_roughness),
            .f0 = vec3(kCoatF0 * layers.coat),
            .f90 = layers.coat};
}

float coatAlbedo(const Layers& layers, float NoV) {
    return layers.coat == 0.0f ? 0.0f
                               : specularAlbedo(NoV, layers.coat_roughness,
                                                vec3(kCoatF0 * layers.coat), layers.coat)
                                     .x;
}

float fibreAlbedo(float NoV, float roughness) {
    static const FibreTable table;
    return table.at(NoV, roughness);
}

float shareUnderLayers(const Layers& layers, float NoV, float NoV_coat) {
    const vec3 none(0.0f);
    return underLayers({.diffuse = none, .alpha = 1.0f, .f0 = vec3(1.0f), .f90 = 0.0f}, layers, NoV,
                       NoV_coat)
        .f0.x;
}

shared::Brdf underLayers(const shared::Brdf& surface, const Layers& layers, float NoV,
                         float NoV_coat) {
    if (layers.none()) {
        return surface;
    }
    const bool fibres = layers.fibre_color != vec3(0.0f);
    const vec3 by_fibres =
        fibres ? layers.fibre_color * fibreAlbedo(NoV, layers.fibre_roughness) : vec3(0.0f);
    const float under_coat = 1.0f - coatAlbedo(layers, NoV_coat);
    const float under_both = under_coat * (1.0f - maxAbs(by_fibres));
    return {.diffuse = under_both * surface.diffuse + under_coat * by_fibres,
            .alpha = surface.alpha,
            .f0 = under_both * surface.f0,
            .f90 = under_both * surface.f90};
}

}  // namespace sheen
