#include "accuracy_truth.h"

#include <algorithm>
#include <cmath>

#include "core/parallel.h"
#include "reference/sampling.h"
#include "reference/sobol.h"

namespace sheen::bench::hemispheres {
namespace {

// The truth: independent Sobol sets, whose spread is its noise.
constexpr int kReplicates = 4;
constexpr uint32_t kCosineRays = 4096;  // a replicate
constexpr uint32_t kLobeRays = 2048;    // a replicate and view
constexpr uint32_t kTruthSeed = 4711;

float seenFrom(const BenchScene& scene, const RecordSite& site, const mat3& frame,
               const std::vector<vec3>& wi, const std::vector<float>& weights) {
    std::vector<vec3> directions;
    std::vector<float> weight;
    for (size_t i = 0; i < wi.size(); ++i) {
        const vec3 d = frame * wi[i];
        if (weights[i] > 0.0f && glm::dot(d, site.geometric_normal) > 0.0f) {
            directions.push_back(d);
            weight.push_back(weights[i]);
        }
    }
    std::vector<vec4> seen(directions.size());
    scene.light.cast({.origin = site.eye(), .directions = directions}, seen.data());
    double sum = 0.0;
    for (size_t i = 0; i < seen.size(); ++i) {
        sum += weight[i] * grey(seen[i]);
    }
    return static_cast<float>(sum / static_cast<double>(wi.size()));
}

// Directions by an independent sampler: cosine for irradiance, visible normals for the lobes.
float truthReplicate(const BenchScene& scene, const RecordSite& site, int quantity, int azimuth,
                     uint32_t seed) {
    const mat3 frame = tangentFrame(site.normal);
    std::vector<vec3> wi;
    std::vector<float> weights;
    if (quantity == 0) {
        for (uint32_t i = 0; i < kCosineRays; ++i) {
            wi.push_back(sampleCosine(owenSobol(i, seed)));
            weights.push_back(kPi);
        }
        return seenFrom(scene, site, frame, wi, weights);
    }
    const vec3 wo = viewer(quantity - 1, azimuth);
    for (uint32_t i = 0; i < kLobeRays; ++i) {
        const vec3 h = sampleGgxVisibleNormal(wo, kAlpha, owenSobol(i, seed));
        const float VoH = glm::dot(wo, h);
        wi.push_back(2.0f * VoH * h - wo);
        weights.push_back(wi.back().z > 0.0f
                              ? glm::mix(kMetalF0, 1.0f, shared::schlickWeight(VoH)) *
                                    visibleNormalWeight(wo.z, wi.back().z, kAlpha)
                              : 0.0f);
    }
    return seenFrom(scene, site, frame, wi, weights);
}

}  // namespace

int azimuthOf(int site) {
    return static_cast<int>(hash32(static_cast<uint32_t>(site)) % kAzimuths);
}

vec3 viewer(int view, int azimuth) {
    const float theta = glm::radians(kViewDegrees[view]);
    const float phi = 2.0f * kPi * (static_cast<float>(azimuth) + 0.25f) / kAzimuths;
    return {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
}

float lobeAlbedo(const vec3& wo) {
    constexpr uint32_t kPoints = 16384;
    const float mu = wo.z;
    double sum = 0.0;
    for (uint32_t i = 0; i < kPoints; ++i) {
        const vec3 h = sampleGgxVisibleNormal(wo, kAlpha, owenSobol(i, 1));
        const vec3 wi = 2.0f * glm::dot(wo, h) * h - wo;
        if (wi.z > 0.0f) {
            sum += glm::mix(kMetalF0, 1.0f, shared::schlickWeight(glm::dot(wo, h))) *
                   visibleNormalWeight(mu, wi.z, kAlpha);
        }
    }
    return static_cast<float>(sum / kPoints);
}

Truth traceTruth(const BenchScenes& scenes, int sites, int quantities) {
    const auto all = scenes.size() * static_cast<size_t>(sites);
    Truth truth{Values(all), Values(all)};
    parallelFor(static_cast<int>(all), [&](int index) {
        const BenchScene& scene = *scenes[static_cast<size_t>(index / sites)];
        const RecordSite& site = scene.sites[static_cast<size_t>(index % sites)];
        for (int q = 0; q < quantities; ++q) {
            double sum = 0.0;
            double squares = 0.0;
            for (int r = 0; r < kReplicates; ++r) {
                const uint32_t seed =
                    hashCombine(kTruthSeed + static_cast<uint32_t>(r * kQuantities + q),
                                static_cast<uint32_t>(index));
                const double v = truthReplicate(scene, site, q, azimuthOf(index), seed);
                sum += v;
                squares += v * v;
            }
            const double mean = sum / kReplicates;
            const auto i = static_cast<size_t>(index);
            truth.values.of[q][i] = static_cast<float>(mean);
            truth.variance.of[q][i] = static_cast<float>(
                std::max(0.0, squares / kReplicates - mean * mean) / (kReplicates - 1));
        }
    });
    return truth;
}

}  // namespace sheen::bench::hemispheres
