#include "gather/light_around.h"

#include <algorithm>
#include <array>
#include <bit>

#include "core/error.h"
#include "light/punctual.h"
#include "rays/jitter.h"
#include "sh/sh.h"

namespace sheen {
namespace {

void add(const vec3& light, const vec3& wi, int order, ShLight& sum) {
    const shared::ShVector y = shared::shBasis(wi, order);
    for (size_t k = 0; k < sum.size(); ++k) {
        sum[k] += y.c[k] * light;
    }
}

uint32_t seedOf(const vec3& p) {
    uint32_t seed = 0;
    for (int axis = 0; axis < 3; ++axis) {
        seed = pcgHash(seed + std::bit_cast<uint32_t>(p[axis]));
    }
    return seed;
}

// What lamps send by the square of the cosine to an axis, of which the six sum to one: samples, of
// which there are fewer toward the horizon, then do.
void addLamps(const Tracer& tracer, const LampSampler& lamps, SurfaceSide point, const vec3& axis,
              bool in_air, int order, uint32_t seed, ShLight& sum) {
    constexpr int kInAir = 256, kOnSurfaces = 64;  // these are many
    const int count = in_air ? kInAir : kOnSurfaces;
    if (in_air) {
        point.n_g = axis;
    }
    SpreadPlaces places(seed, 0);
    for (int first = 0; first < count; first += Tracer::kPacket) {
        std::array<std::optional<LampSampler::Sample>, Tracer::kPacket> samples;
        std::array<Way, Tracer::kPacket> ways;
        for (size_t k = 0; k < samples.size(); ++k) {
            samples[k] = lamps.sample(point, axis, places.next());
            ways[k] = samples[k] ? samples[k]->way : Way{};
        }
        const Tracer::Shares passing = tracer.passing(ways);
        for (size_t k = 0; k < samples.size(); ++k) {
            if (samples[k] && passing[k] != vec3(0.0f)) {
                const LampSampler::Sample& s = *samples[k];
                const float cosine = glm::dot(s.wi, axis);
                const float weight = cosine * cosine / (s.density * static_cast<float>(count));
                add(weight * passing[k] * s.radiance, s.wi, order, sum);
            }
        }
    }
}

}  // namespace

std::vector<ShLight> gatherAround(Gatherer& gatherer, std::span<const vec3> points, int order) {
    constexpr std::array<vec3, 2> kPoles = {vec3(0, 1, 0), vec3(0, -1, 0)};
    std::vector<RecordSite> sites;
    for (const vec3& p : points) {
        for (const vec3& pole : kPoles) {
            sites.push_back({.position = p,
                             .normal = pole,
                             .geometric_normal = pole,
                             .seed = pcgHash(seedOf(p) + static_cast<uint32_t>(sites.size() % 2)),
                             .order = order});
        }
    }
    const std::vector<GatheredRecord> found = gatherer.gather(sites);
    const auto size = static_cast<size_t>(order * order);
    std::vector<ShLight> light(points.size(), ShLight(size, vec3(0.0f)));
    for (size_t i = 0; i < found.size(); ++i) {
        SHEEN_CHECK(found[i].sh.size() >= 3 * size);
        for (size_t k = 0; k < 3 * size; ++k) {
            light[i / kPoles.size()][k % size][static_cast<int>(k / size)] += found[i].sh[k];
        }
    }
    return light;
}

ShLight directAround(const Tracer& tracer, const SceneLights& lights, const SurfaceSide& point,
                     float radius, int order, uint32_t seed) {
    const bool in_air = radius > 0.0f;
    ShLight sum(static_cast<size_t>(order * order), vec3(0.0f));
    const vec3 start = in_air ? point.position : point.start();
    for (const PunctualLight& light : tracer.scene().lights) {
        LightSample s = shared::sampleLight(light, point.position);
        if (in_air && s.distance >= 0.0f) {
            const float nearness = std::min(s.distance / radius, 1.0f);
            s.irradiance *= nearness * nearness;
        }
        if (s.wi == vec3(0.0f) || !finite(s.irradiance)) {
            continue;  // it lies there, or so near that no number tells
        }
        if (s.irradiance == vec3(0.0f) || (!in_air && glm::dot(s.wi, point.n_g) <= 0.0f)) {
            continue;
        }
        const Way way = wayTo(light, s, start);
        const vec3 share = tracer.passing({&way, 1})[0];
        if (share != vec3(0.0f)) {
            add(share * s.irradiance, s.wi, order, sum);
        }
    }
    for (int side = 0; side < 6 && !lights.lamps.empty(); ++side) {
        vec3 axis(0.0f);
        axis[side / 2] = side % 2 == 0 ? 1.0f : -1.0f;
        addLamps(tracer, lights.lamps, point, axis, in_air, order,
                 pcgHash(seed + static_cast<uint32_t>(side)), sum);
    }
    return sum;
}

}  // namespace sheen
