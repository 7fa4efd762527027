// Two passes over the pixels: each sees its lobe by rays of its own, then averages what its
// neighbours saw, as far as their lobes overlap with its own. Based on: [KDB16], with the distance
// of what is reflected as in [Zhd21].
#include "cache/specular_rays.h"

#include <algorithm>
#include <cmath>

#include "cache/record.h"
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

struct Lobe {
    vec3 position, n, wo;
    float alpha;

    Lobe(const GBuffer& gbuffer, size_t i)
        : position(gbuffer.position.pixels[i]),
          n(gbuffer.normal.pixels[i]),
          wo(glm::normalize(gbuffer.view.origin - position)),
          alpha(shared::alphaFromRoughness(gbuffer.normal.pixels[i].w)) {}
};

// What a pixel's own rays saw.
struct Seen {
    vec3 light{};        // the lobe's mean of what arrives: one for constant light of one
    float nearness = 0;  // mean of one over the distance it comes from; 0: no ray met anything
    vec3 mirrored{};     // where it comes from: the direction that mirrors the viewer's
};

// The mean of what the rays see, weighted by the estimator of visible normals, F G2 / G1. Dividing
// by the weights' own mean takes their noise away.
Seen see(const RayCaster& rays, const LightCells* cells, const GBuffer& gbuffer, size_t i,
         const SpecularParams& params) {
    const Lobe lobe(gbuffer, i);
    const vec3 n_g = gbuffer.geometricNormalAt(rays.scene(), static_cast<int>(i));
    const mat3 frame = tangentFrame(lobe.n);
    const vec3 wo_local = glm::transpose(frame) * lobe.wo;
    const float NoV = std::max(wo_local.z, shared::MIN_COSINE);
    const vec3 f0(gbuffer.f0.pixels[i]);
    const float f90 = gbuffer.diffuse.pixels[i].w;
    const vec3 eye = rays.origin(lobe.position, n_g, lobe.wo);
    const float wanted =
        std::min(params.rays_per_alpha * lobe.alpha, static_cast<float>(params.max_rays));
    const int rows = std::max(static_cast<int>(std::ceil(wanted / kRowSamples)), 1);
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
                // One over the rays' density: D G1 / (4 NoV) of each. [Hei18, eq. 17]
                const float density = static_cast<float>(rows * kRowSamples) *
                                      shared::distributionGgx(h.z, lobe.alpha) *
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

// The passes' images, and how pixels share what is in them.
class Sharing {
  public:
    Sharing(const Scene& scene, const GBuffer& gbuffer, const PixelClasses& classes,
            const Image<Seen>& seen, const SpecularParams& params)
        : scene_(scene), gbuffer_(gbuffer), classes_(classes), seen_(seen), params_(params) {}

    // The mean light of the pixels around (x, y) whose lobes overlap. Pixels on opposite sides
    // weigh the same: one side alone, as at an edge, would stand for light that the other lacks.
    vec3 lightAt(const Lobe& lobe, int x, int y) const {
        vec3 sum = seen_.at(x, y).light;
        float all = 1.0f;
        for (int dy = 0; dy <= params_.window; ++dy) {
            for (int dx = dy == 0 ? 1 : -params_.window; dx <= params_.window; ++dx) {
                const ivec2 d(dx, dy);
                float weight = overlap(lobe, ivec2(x, y), d);
                if (weight > 0.0f) {
                    weight = std::min(weight, overlap(lobe, ivec2(x, y), -d));
                }
                if (weight > 0.0f) {
                    sum +=
                        weight * (seen_.at(x + dx, y + dy).light + seen_.at(x - dx, y - dy).light);
                    all += 2.0f * weight;
                }
            }
        }
        return sum / all;
    }

  private:
    // From 1, the same lobe, to 0: in the half vector's slope, of which GGX has the width alpha
    // however narrow grazing views make the lobe. What the neighbour mirrors lies at the distance
    // found, and from here in another direction.
    float overlap(const Lobe& lobe, const ivec2& own, const ivec2& step) const {
        const ivec2 at = own + step;
        if (at.x < 0 || at.y < 0 || at.x >= gbuffer_.width || at.y >= gbuffer_.height ||
            classes_.by_rays.at(at.x, at.y) == 0 || materialAt(at) != materialAt(own)) {
            return 0.0f;
        }
        const vec3 offset = vec3(gbuffer_.position.at(at.x, at.y)) - lobe.position;
        const float footprint = gbuffer_.pixel_angle * gbuffer_.position.at(own.x, own.y).w;
        if (std::abs(glm::dot(offset, lobe.n)) > kOffPlane * footprint) {
            return 0.0f;
        }
        const Seen& there = seen_.at(at.x, at.y);
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
    const Image<Seen>& seen_;
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

Image<vec3> gatherSpecular(const RayCaster& rays, const LightCells* cells, const GBuffer& gbuffer,
                           const PixelClasses& classes, const SpecularParams& params) {
    Image<Seen> seen(gbuffer.width, gbuffer.height);
    forEachByRays(classes, [&](int x, int y) {
        const size_t i = static_cast<size_t>(y) * gbuffer.width + x;
        seen.pixels[i] = see(rays, cells, gbuffer, i, params);
    });
    const Sharing sharing(rays.scene(), gbuffer, classes, seen, params);
    Image<vec3> specular(gbuffer.width, gbuffer.height);
    forEachByRays(classes, [&](int x, int y) {
        const Lobe lobe(gbuffer, static_cast<size_t>(y) * gbuffer.width + x);
        const vec2 ab = brdfAlbedo(glm::dot(lobe.n, lobe.wo), gbuffer.normal.at(x, y).w);
        const float f90 = gbuffer.diffuse.at(x, y).w;
        specular.at(x, y) =
            (vec3(gbuffer.f0.at(x, y)) * ab.x + vec3(f90 * ab.y)) * sharing.lightAt(lobe, x, y);
    });
    return specular;
}

}  // namespace sheen
