// Directions distributed for the BRDF: a mixture of a cosine lobe and the GGX distribution of
// visible normals, and for a coat of that of its own, weighted by the one-sample balance heuristic.
// Based on: [VG95], [Hei18].
#pragma once

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/directions.h"
#include "reference/sobol.h"
#include "scene/ggx_sampling.h"
#include "scene/shared.h"

namespace sheen {

/// A direction of the upper hemisphere (z up) by density cos/pi per solid angle; u in [0, 1)^2.
/// The disc is reached by the concentric map, which keeps strata compact. [SC97]
inline vec3 sampleCosine(const vec2& u) {
    const vec2 s = 2.0f * u - vec2(1.0f);
    vec2 p(0.0f);
    if (std::abs(s.x) > std::abs(s.y)) {
        const float phi = 0.25f * kPi * (s.y / s.x);
        p = s.x * vec2(std::cos(phi), std::sin(phi));
    } else if (s.y != 0.0f) {
        const float phi = 0.5f * kPi - 0.25f * kPi * (s.x / s.y);
        p = s.y * vec2(std::cos(phi), std::sin(phi));
    }
    return {p.x, p.y, std::sqrt(std::max(0.0f, 1.0f - p.x * p.x - p.y * p.y))};
}

/// Density per solid angle of reflecting wo about a microfacet normal from sampleGgxVisibleNormal.
inline float ggxReflectionPdf(const vec3& n, const vec3& wo, const vec3& wi, float alpha) {
    const float NoV = std::max(glm::dot(n, wo), shared::MIN_COSINE);
    // As in shared::specularLobe, digit for digit: where the lobe is so narrow that NoH is coarse,
    // its errors cancel in f / pdf.
    const vec3 h = glm::normalize(wo + wi);
    const float NoH = glm::clamp(glm::dot(n, h), 0.0f, 1.0f);
    return reflectedDensity(NoV, NoH, alpha);
}

/// A clear coat over a surface point: a BRDF of its own about a normal of its own.
struct Coat {
    shared::Brdf brdf;
    vec3 n{0.0f};         ///< unit, on the viewer's side
    float albedo = 0.0f;  ///< toward the viewer
};

/// What the coat, where there is one, sends of light from wi toward wo: its BRDF times its cosine.
inline vec3 evalCoat(const std::optional<Coat>& coat, const vec3& wo, const vec3& wi) {
    return coat ? shared::evalBrdf(coat->brdf, coat->n, wo, wi) *
                      std::max(glm::dot(coat->n, wi), 0.0f)
                : vec3(0.0f);
}

/// How a surface point spreads its samples; made once a point.
struct BrdfSampler {
    mat3 world_from_local{1.0f};
    vec3 wo_local{0.0f};
    float specular_share = 0.0f;  ///< of those not the coat's, taken from the GGX lobe
    std::optional<Coat> coat;
    float coat_share = 0.0f;  ///< of the samples, taken from the coat's lobe

    /// `specular_albedo` is the specular lobe's directional albedo.
    BrdfSampler(const shared::Brdf& brdf, const vec3& specular_albedo, const vec3& n,
                const vec3& wo, const std::optional<Coat>& coat_ = {})
        : world_from_local(tangentFrame(n)), wo_local(wo * world_from_local), coat(coat_) {
        if (coat) {
            const float below =
                std::max({specular_albedo.x + brdf.diffuse.x, specular_albedo.y + brdf.diffuse.y,
                          specular_albedo.z + brdf.diffuse.z, 1e-6f});
            coat_share =
                glm::clamp(std::round(8.0f * coat->albedo / (coat->albedo + below)), 2.0f, 6.0f) /
                8.0f;
        }
        const float specular = specular_albedo.x + specular_albedo.y + specular_albedo.z;
        const float diffuse = brdf.diffuse.x + brdf.diffuse.y + brdf.diffuse.z;
        if (specular <= 0.0f) {
            specular_share = 0.0f;
        } else if (diffuse <= 0.0f) {
            specular_share = 1.0f;
        } else {
            // Eighths: slicing Sobol points at dyadic places leaves each slice well stratified.
            // A weak lobe still gets a quarter: it may show a light the cosine lobe rarely finds.
            const float eighths = std::round(8.0f * specular / (specular + diffuse));
            specular_share = glm::clamp(eighths, 2.0f, 7.0f) / 8.0f;
        }
    }
};

/// Density per solid angle by which sampleBrdf() chooses wi and keeps it: what a lobe sends below
/// the hemisphere of its own normal is dropped.
inline float brdfPdf(const BrdfSampler& sampler, const shared::Brdf& brdf, const vec3& n,
                     const vec3& wo, const vec3& wi) {
    float pdf = 0.0f;
    if (const float NoL = glm::dot(n, wi); NoL > 0.0f) {
        const float share = sampler.specular_share;
        const float specular_pdf = share > 0.0f ? ggxReflectionPdf(n, wo, wi, brdf.alpha) : 0.0f;
        pdf = share * specular_pdf + (1.0f - share) * NoL / kPi;
    }
    if (sampler.coat) {
        const Coat& coat = *sampler.coat;
        const float coat_pdf =
            glm::dot(coat.n, wi) > 0.0f ? ggxReflectionPdf(coat.n, wo, wi, coat.brdf.alpha) : 0.0f;
        pdf = sampler.coat_share * coat_pdf + (1.0f - sampler.coat_share) * pdf;
    }
    return pdf;
}

/// A direction, and the BRDF times cosine over its density, the coat's included. Both weights are 0
/// where it was dropped; such a sample counts, and there is
/// nothing to trace.
struct DirectionSample {
    vec3 wi{0.0f};       ///< unit, world space
    float pdf = 0.0f;    ///< per solid angle
    vec3 weight{0.0f};   ///< of the whole BRDF
    vec3 diffuse{0.0f};  ///< of its diffuse term
};

/// u in [0, 1)^2.
inline DirectionSample sampleBrdf(const BrdfSampler& sampler, const shared::Brdf& brdf,
                                  const vec3& n, const vec3& wo, vec2 u) {
    const float share = sampler.specular_share;
    DirectionSample s;
    if (u.x < sampler.coat_share) {
        u.x = std::min(u.x / sampler.coat_share, kBelowOne);
        const Coat& coat = *sampler.coat;
        const mat3 frame = tangentFrame(coat.n);
        const vec3 local = wo * frame;
        const vec3 h = sampleGgxVisibleNormal(local, coat.brdf.alpha, u);
        s.wi = glm::normalize(frame * (2.0f * glm::dot(local, h) * h - local));
        if (!(glm::dot(coat.n, s.wi) > 0.0f)) {
            return s;
        }
    } else {
        if (sampler.coat) {
            u.x = std::min((u.x - sampler.coat_share) / (1.0f - sampler.coat_share), kBelowOne);
        }
        vec3 wi_local;
        if (u.x < share) {
            u.x = std::min(u.x / share, kBelowOne);
            const vec3 h = sampleGgxVisibleNormal(sampler.wo_local, brdf.alpha, u);
            wi_local = 2.0f * glm::dot(sampler.wo_local, h) * h - sampler.wo_local;
        } else {
            u.x = std::min((u.x - share) / (1.0f - share), kBelowOne);
            wi_local = sampleCosine(u);
        }
        s.wi = glm::normalize(sampler.world_from_local * wi_local);
        if (!(glm::dot(n, s.wi) > 0.0f)) {
            return s;
        }
    }
    const float NoL = glm::dot(n, s.wi);
    s.pdf = brdfPdf(sampler, brdf, n, wo, s.wi);
    if (s.pdf > 0.0f) {
        s.weight = shared::evalBrdf(brdf, n, wo, s.wi) * (NoL / s.pdf);
        s.diffuse = brdf.diffuse * (std::max(NoL, 0.0f) / (kPi * s.pdf));
        if (sampler.coat) {
            s.weight += evalCoat(sampler.coat, wo, s.wi) / s.pdf;
        }
    }
    return s;
}

}  // namespace sheen
