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

// A row of samples is a packet of rays; how many rows a lobe gets follows from its width.
constexpr int kRowSamples = RayCaster::kPacket;
constexpr float kRowsPerAlpha = 160.0f;
constexpr int kMaxRows = 16;

// What pixel i's lobe reflects: its albedo times the mean of what the rays see, weighted by the
// estimator of visible normals, F G2 / G1. The weights' own mean is the albedo as well; dividing by
// it takes their noise away, and constant light is reflected exactly.
vec3 reflected(const RayCaster& rays, const GBuffer& gbuffer, const vec3& n_g, size_t i) {
    const vec3 position(gbuffer.position.pixels[i]);
    const vec3 n(gbuffer.normal.pixels[i]);
    const vec3 wo = glm::normalize(gbuffer.view.origin - position);
    const mat3 frame = tangentFrame(n);
    const vec3 wo_local = glm::transpose(frame) * wo;
    const float NoV = std::max(wo_local.z, shared::MIN_COSINE);
    const float alpha = shared::alphaFromRoughness(gbuffer.normal.pixels[i].w);
    const vec3 f0(gbuffer.f0.pixels[i]);
    const float f90 = gbuffer.diffuse.pixels[i].w;
    const vec3 eye = rays.origin(position, n_g, wo);
    const int rows = std::clamp(static_cast<int>(std::ceil(kRowsPerAlpha * alpha)), 1, kMaxRows);
    vec3 sum(0.0f);
    vec3 all(0.0f);
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
            const vec3 h = sampleGgxVisibleNormal(wo_local, alpha, u);
            const float VoH = glm::dot(wo_local, h);
            const vec3 wi = 2.0f * VoH * h - wo_local;
            const vec3 direction = frame * wi;
            if (wi.z <= 0.0f || VoH <= 0.0f) {
                continue;
            }
            const vec3 fresnel = f0 + (vec3(f90) - f0) * shared::schlickWeight(VoH);
            const vec3 weight = fresnel * visibleNormalWeight(NoV, wi.z, alpha);
            all += weight;
            if (glm::dot(direction, n_g) > 0.0f) {
                directions[count] = glm::normalize(direction);
                // One over the rays' density: D G1 / (4 NoV) of each. [Hei18, eq. 19]
                const float density = static_cast<float>(rows * kRowSamples) *
                                      shared::distributionGgx(h.z, alpha) *
                                      maskingSmith(NoV, alpha) / (4.0f * NoV);
                solid_angles[count] = std::min(1.0f / std::max(density, 1e-12f), kPi);
                weights[count++] = weight;
            }
        }
        rays.cast({.origin = eye,
                   .directions = {directions, count},
                   .solid_angles = {solid_angles, count}},
                  seen);
        for (size_t k = 0; k < count; ++k) {
            sum += weights[k] * vec3(seen[k]);
        }
    }
    const vec2 ab = brdfAlbedo(NoV, gbuffer.normal.pixels[i].w);
    return (f0 * ab.x + vec3(f90 * ab.y)) * sum / glm::max(all, vec3(1e-12f));
}

}  // namespace

Image<vec3> gatherSpecular(const RayCaster& rays, const Scene& scene, const GBuffer& gbuffer,
                           const PixelClasses& classes) {
    Image<vec3> specular(gbuffer.width, gbuffer.height);
    parallelFor(gbuffer.height, [&](int y) {
        for (int x = 0; x < gbuffer.width; ++x) {
            if (classes.by_rays.at(x, y) == 0) {
                continue;
            }
            const int i = y * gbuffer.width + x;
            specular.at(x, y) = reflected(rays, gbuffer, gbuffer.geometricNormalAt(scene, i),
                                          static_cast<size_t>(i));
        }
    });
    return specular;
}

}  // namespace sheen
