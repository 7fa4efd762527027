// Sampling the GGX distribution of visible normals. Based on: [Hei18].
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/math.h"
#include "scene/shared.h"

namespace sheen {

/// A microfacet normal visible from `wo_local` (unit, z is the surface normal, z > 0), by the
/// distribution D_v(h) = G1(wo) max(0, wo.h) D(h) / wo.z; u in [0, 1)^2. [Hei18, listing 1]
inline vec3 sampleGgxVisibleNormal(const vec3& wo_local, float alpha, const vec2& u) {
    const vec3 v = glm::normalize(vec3(alpha * wo_local.x, alpha * wo_local.y, wo_local.z));
    const float length2 = v.x * v.x + v.y * v.y;
    const vec3 t1 = length2 > 0.0f ? vec3(-v.y, v.x, 0.0f) / std::sqrt(length2) : vec3(1, 0, 0);
    const vec3 t2 = glm::cross(v, t1);
    const float r = std::sqrt(u.x);
    const float phi = 2.0f * kPi * u.y;
    const float p1 = r * std::cos(phi);
    const float s = 0.5f * (1.0f + v.z);
    const float p2 = (1.0f - s) * std::sqrt(1.0f - p1 * p1) + s * r * std::sin(phi);
    const vec3 n = p1 * t1 + p2 * t2 + std::sqrt(std::max(0.0f, 1.0f - p1 * p1 - p2 * p2)) * v;
    return glm::normalize(vec3(alpha * n.x, alpha * n.y, std::max(1e-6f, n.z)));
}

/// Smith masking G1 of one direction with cosine `mu`. [Hei14, eq. 72]
inline float maskingSmith(float mu, float alpha) {
    const float tan2 = (1.0f - mu * mu) / std::max(mu * mu, 1e-12f);
    return 2.0f / (1.0f + std::sqrt(1.0f + alpha * alpha * tan2));
}

/// How dense, over solid angle, the directions are that wo is reflected to by these microfacet
/// normals: `mu` the cosine of wo, `NoH` of the normal. [Hei18, eq. 17]
inline float reflectedDensity(float mu, float NoH, float alpha) {
    return maskingSmith(mu, alpha) * shared::distributionGgx(NoH, alpha) / (4.0f * mu);
}

/// What a sample by visible normals weighs, the Fresnel factor not included: BRDF times cosine over
/// the probability of the direction, G2 / G1. `mu` and `NoL`: cosines of wo and of the direction.
/// [Hei18]
inline float visibleNormalWeight(float mu, float NoL, float alpha) {
    const float g2 = 4.0f * NoL * mu * shared::visibilitySmith(mu, NoL, alpha);
    return g2 / maskingSmith(mu, alpha);
}

/// A direction that a specular lobe sends light from toward wo.
struct LobeSample {
    vec3 wi;        ///< unit, z is the surface normal
    vec3 weight;    ///< BRDF times cosine over the density
    float density;  ///< over solid angle, above 0
};

/// By a visible normal; u in [0, 1)^2. None where the numbers lead below the surface.
inline std::optional<LobeSample> sampleLobe(const vec3& wo_local, float alpha, const vec3& f0,
                                            float f90, const vec2& u) {
    const vec3 h = sampleGgxVisibleNormal(wo_local, alpha, u);
    const float VoH = glm::dot(wo_local, h);
    const vec3 wi = 2.0f * VoH * h - wo_local;
    if (wi.z <= 0.0f || VoH <= 0.0f) {
        return std::nullopt;
    }
    const float mu = std::max(wo_local.z, shared::MIN_COSINE);
    const vec3 fresnel = f0 + (vec3(f90) - f0) * shared::schlickWeight(VoH);
    return LobeSample{.wi = wi,
                      .weight = fresnel * visibleNormalWeight(mu, wi.z, alpha),
                      .density = std::max(reflectedDensity(mu, h.z, alpha), 1e-12f)};
}

}  // namespace sheen
