// Two passes over the pixels: each sees its lobe by rays of its own, then averages what its
// neighbours saw. Based on: [KDB16], with the distance of what is reflected as in [Zhd21]. Where
// there are records, they are a control variate: what is averaged is the remainder.
#include "cache/specular_rays.h"

#include <algorithm>
#include <cmath>

#include "cache/lobes.h"
#include "core/parallel.h"
#include "rays/jitter.h"
#include "scene/brdf_albedo.h"
#include "scene/ggx_sampling.h"

namespace sheen {
namespace {

// A row of samples is a packet of rays.
constexpr int kRowSamples = RayCaster::kPacket;
// Pixels share no rays across a step of more footprints than this off the tangent plane.
constexpr float kOffPlane = 3.0f;
// The variance of what a pixel's rays see over that of what its records miss, typically.
constexpr float kNoiseOverMissed = 10.0f;

struct Lobe {
    vec3 position, n, wo;
    float alpha;

    Lobe(const GBuffer& gbuffer, const ivec2& at)
        : position(gbuffer.position.at(at.x, at.y)),
          n(gbuffer.normal.at(at.x, at.y)),
          wo(glm::normalize(gbuffer.view.origin - position)),
          alpha(shared::alphaFromRoughness(gbuffer.normal.at(at.x, at.y).w)) {}
};

// What a pixel sees by this share of the usual rays, when `sharing` pixels share them. A ray sees
// highlights as wide as the cone it stands for: where that is counted too wide, mirrored highlights
// are blurred. The mean of what the rays see, weighted by the estimator of visible normals, F G2 /
// G1. Dividing by the weights' own mean takes their noise away.
SpecularSeen see(const RayCaster& rays, const LightCells* cells, const GBuffer& gbuffer,
                 const ivec2& at, float rays_share, float sharing, const SpecularParams& params) {
    const Lobe lobe(gbuffer, at);
    const int i = at.y * gbuffer.width + at.x;
    const vec3 n_g = gbuffer.geometricNormalAt(rays.scene(), i);
    const mat3 frame = tangentFrame(lobe.n);
    const vec3 wo_local = glm::transpose(frame) * lobe.wo;
    const float NoV = std::max(wo_local.z, shared::MIN_COSINE);
    const vec3 f0(gbuffer.f0.at(at.x, at.y));
    const float f90 = gbuffer.diffuse.at(at.x, at.y).w;
    const vec3 eye = rays.origin(lobe.position, n_g, lobe.wo);
    const float wanted = rays_share * std::min(params.rays_per_alpha * lobe.alpha,
                                               static_cast<float>(params.max_rays));
    const int rows = std::max(static_cast<int>(std::ceil(wanted / kRowSamples)), 1);
    const float rays_sharing = static_cast<float>(rows * kRowSamples) * sharing;
    vec3 sum(0.0f);
    vec3 all(0.0f);
    float nearness = 0.0f;
    for (int row = 0; row < rows; ++row) {
        vec3 directions[kRowSamples];
        vec3 weights[kRowSamples];
        float solid_angles[kRowSamples];  // that the rays stand for
        vec4 seen[kRowSamples];
        size_t count = 0;
        for (int k = 0; k < kRowSamples; ++k) {
            const vec2 place =
                randomPlace(static_cast<uint32_t>(i), static_cast<uint32_t>(row * kRowSamples + k));
            const vec2 u = (vec2(row, k) + place) / vec2(rows, kRowSamples);
            const vec3 h = sampleGgxVisibleNormal(wo_local, lobe.alpha, u);
            const float VoH = glm::dot(wo_local, h);
            const vec3 wi = 2.0f * VoH * h - wo_local;
            const vec3 direction = frame * wi;
            if (wi.z <= 0.0f || VoH <= 0.0f) {
                continue;
            }
            const vec3 fresnel = f0 + (vec3(f90) - f0) * shared::schlickWeight(VoH);
            const vec3 weight = fresnel * visibleNormalWeight(NoV, wi.z, lobe.alpha);
            all += weight;
            if (glm::dot(direction, n_g) > 0.0f) {
                directions[count] = glm::normalize(direction);
                // One over the density of the rays, D G1 / (4 NoV) of each [Hei18, eq. 17], those
                // of the pixels that share them included.
                const float density = rays_sharing * shared::distributionGgx(h.z, lobe.alpha) *
                                      maskingSmith(NoV, lobe.alpha) / (4.0f * NoV);
                solid_angles[count] = std::min(1.0f / std::max(density, 1e-12f), kPi);
                weights[count++] = weight;
            }
        }
        rays.cast({.origin = eye,
                   .directions = {directions, count},
                   .solid_angles = {solid_angles, count}},
                  seen, cells);
        for (size_t k = 0; k < count; ++k) {
            sum += weights[k] * vec3(seen[k]);
            nearness += seen[k].w > 0.0f ? 1.0f / seen[k].w : 0.0f;
        }
    }
    return {.light = sum / glm::max(all, vec3(1e-12f)),
            .nearness = nearness / static_cast<float>(rows * kRowSamples),
            .mirrored = glm::reflect(-lobe.wo, lobe.n)};
}

// How pixels share what they saw or, those that have records too, what these miss of it: `light`.
class Sharing {
  public:
    Sharing(const Scene& scene, const GBuffer& gbuffer, const PixelClasses& classes,
            const Image<SpecularSeen>& seen, const Image<vec3>& light, const SpecularParams& params)
        : scene_(scene),
          gbuffer_(gbuffer),
          classes_(classes),
          seen_(seen),
          light_(light),
          params_(params) {}

    // The mean of the pixels around `own` whose lobes overlap. Pixels on opposite sides weigh the
    // same: one side alone, as at an edge, would stand for light that the other lacks.
    vec3 lightAround(const ivec2& own) const {
        const Lobe lobe(gbuffer_, own);
        vec3 sum = light_.at(own.x, own.y);
        float all = 1.0f;
        for (int dy = 0; dy <= params_.window; ++dy) {
            for (int dx = dy == 0 ? 1 : -params_.window; dx <= params_.window; ++dx) {
                const ivec2 a = own + ivec2(dx, dy);
                const ivec2 b = own - ivec2(dx, dy);
                float weight = overlap(lobe, own, a);
                if (weight > 0.0f) {
                    weight = std::min(weight, overlap(lobe, own, b));
                }
                if (weight > 0.0f) {
                    sum += weight * (light_.at(a.x, a.y) + light_.at(b.x, b.y));
                    all += 2.0f * weight;
                }
            }
        }
        return sum / all;
    }

    // The mean of the pixels around `own`, by a Gaussian: what records miss is small beside the
    // light and changes slowly, so that more pixels have it in common, at contacts too. As the best
    // estimate of a value of known variance from n noisy ones is, it is n / (n + the ratio of the
    // variances) of their mean: on a silhouette few pixels tell what is missed.
    vec3 missedAround(const ivec2& own) const {
        const Lobe lobe(gbuffer_, own);
        const float deviation = 0.5f * static_cast<float>(params_.window);
        vec3 sum = light_.at(own.x, own.y);
        float all = 1.0f;
        float squares = 1.0f;
        for (int dy = -params_.window; dy <= params_.window; ++dy) {
            for (int dx = -params_.window; dx <= params_.window; ++dx) {
                const ivec2 at = own + ivec2(dx, dy);
                if (at != own && alike(lobe, own, at) && finiteAt(at)) {
                    const auto square = static_cast<float>(dx * dx + dy * dy);
                    const float weight = std::exp(-0.5f * square / (deviation * deviation));
                    sum += weight * light_.at(at.x, at.y);
                    all += weight;
                    squares += weight * weight;
                }
            }
        }
        const float pixels = all * all / squares;
        return pixels / (pixels + kNoiseOverMissed) * sum / all;
    }

  private:
    // Whether rays say as much of both, on the same surface, without a step between.
    bool alike(const Lobe& lobe, const ivec2& own, const ivec2& at) const {
        if (at.x < 0 || at.y < 0 || at.x >= gbuffer_.width || at.y >= gbuffer_.height ||
            classes_.by_rays.at(at.x, at.y) == 0 ||
            classes_.isCorrected(at.x, at.y) != classes_.isCorrected(own.x, own.y) ||
            materialAt(at) != materialAt(own)) {
            return false;
        }
        const vec3 offset = vec3(gbuffer_.position.at(at.x, at.y)) - lobe.position;
        const float footprint = gbuffer_.pixel_angle * gbuffer_.position.at(own.x, own.y).w;
        return std::abs(glm::dot(offset, lobe.n)) <= kOffPlane * footprint;
    }
    // What records could not say, compose() counts at one pixel; none around is to suffer from it.
    bool finiteAt(const ivec2& at) const {
        const vec3& light = light_.at(at.x, at.y);
        return std::isfinite(light.x + light.y + light.z);
    }
    // From 1, the same lobe, to 0: in the half vector's slope, of which GGX has the width alpha
    // however narrow grazing views make the lobe. What the neighbour mirrors lies at the distance
    // found, and from here in another direction.
    float overlap(const Lobe& lobe, const ivec2& own, const ivec2& at) const {
        if (!alike(lobe, own, at)) {
            return 0.0f;
        }
        const vec3 offset = vec3(gbuffer_.position.at(at.x, at.y)) - lobe.position;
        const SpecularSeen& there = seen_.at(at.x, at.y);
        const float nearness = std::max(there.nearness, seen_.at(own.x, own.y).nearness);
        const vec3 h = lobe.wo + glm::normalize(there.mirrored + offset * nearness);
        const float NoH = glm::dot(h, lobe.n);
        const float slope = glm::length(h - NoH * lobe.n);
        const float reach = params_.overlap * lobe.alpha * NoH;
        return slope < reach ? 1.0f - slope * slope / (reach * reach) : 0.0f;
    }
    uint32_t materialAt(const ivec2& at) const {
        return scene_.materials_of[gbuffer_.primitive.at(at.x, at.y)];
    }

    const Scene& scene_;
    const GBuffer& gbuffer_;
    const PixelClasses& classes_;
    const Image<SpecularSeen>& seen_;
    const Image<vec3>& light_;
    const SpecularParams& params_;
};

// Calls body(x, y) for the pixels gathered by rays.
template <class F>
void forEachByRays(const PixelClasses& classes, const F& body) {
    parallelFor(classes.by_rays.height, [&](int y) {
        for (int x = 0; x < classes.by_rays.width; ++x) {
            if (classes.by_rays.at(x, y) != 0) {
                body(x, y);
            }
        }
    });
}

}  // namespace

Image<SpecularSeen> traceSpecular(const RayCaster& rays, const LightCells* cells,
                                  const GBuffer& gbuffer, const PixelClasses& classes,
                                  const SpecularParams& params) {
    // As many pixels as a Gaussian of half the window counts for: 4 pi times its variance.
    const auto window = static_cast<float>(params.window);
    const float sharing = std::max(kPi * window * window, 1.0f);
    Image<SpecularSeen> seen(gbuffer.width, gbuffer.height);
    forEachByRays(classes, [&](int x, int y) {
        if (!classes.isCorrected(x, y)) {
            seen.at(x, y) = see(rays, cells, gbuffer, {x, y}, 1.0f, 1.0f, params);
            return;
        }
        // Their noise shows by the lobe's share of what a pixel reflects: so do their rays [Ney34].
        const float specular = luminance(specularAlbedo(gbuffer, y * gbuffer.width + x));
        const float all = specular + luminance(vec3(gbuffer.diffuse.at(x, y)));
        const float share = specular / std::max(all, 1e-12f);
        seen.at(x, y) = see(rays, cells, gbuffer, {x, y}, share, sharing, params);
    });
    return seen;
}

Image<vec3> reflectSpecular(const Scene& scene, const GBuffer& gbuffer, const PixelClasses& classes,
                            const Image<SpecularSeen>& seen, const Image<vec3>& cached,
                            const SpecularParams& params) {
    Image<vec3> albedos(gbuffer.width, gbuffer.height);
    Image<vec3> light(gbuffer.width, gbuffer.height);
    forEachByRays(classes, [&](int x, int y) {
        const vec3 albedo = specularAlbedo(gbuffer, y * gbuffer.width + x);
        albedos.at(x, y) = albedo;
        light.at(x, y) = seen.at(x, y).light - cached.at(x, y) / glm::max(albedo, vec3(1e-12f));
    });
    const Sharing sharing(scene, gbuffer, classes, seen, light, params);
    Image<vec3> specular(gbuffer.width, gbuffer.height);
    forEachByRays(classes, [&](int x, int y) {
        const vec3 shared =
            classes.isCorrected(x, y) ? sharing.missedAround({x, y}) : sharing.lightAround({x, y});
        specular.at(x, y) = cached.at(x, y) + albedos.at(x, y) * shared;
    });
    return specular;
}

}  // namespace sheen
