#include "reference/paths.h"

#include <algorithm>

#include "reference/sobol.h"

namespace sheen {
namespace {

constexpr uint32_t kSkySeed = 0x736b7900u;

// Of all bounces these are always followed; then a path goes on with the chance that is the
// brightest of what its channels have left, but never surely, so that it ends in white rooms too.
constexpr int kSureBounces = 3;
constexpr float kLikeliest = 0.95f;
constexpr uint32_t kRouletteSeed = 0x726f756cu;

// What a path brings, and what of it specular lobes alone have scattered, once at least.
struct Brought {
    vec3 all{0.0f};
    vec3 specular{0.0f};
};

// What lights of all kinds send from a path's vertex, but for the half of lamps and sky that the
// path's next ray finds.
Scattered lightAtVertex(const PathContext& context, const Surface& q, const BrdfSampler& sampler,
                        uint32_t index, uint32_t seed, Counters& counters) {
    const RayScene& rays = context.rays;
    const Lights& lights = context.lights;
    Scattered light = scatterPunctual(rays, q, counters);
    if (!lights.lamps.empty()) {
        const LightChoice lamp =
            lights.lamps.choose(q.rayOrigin(), owenSobol(index, hashCombine(seed, kLampSeed)));
        light.add(scatterChosen(rays, q, sampler, lamp, counters));
    }
    if (!lights.sky.empty()) {
        const LightChoice sky =
            lights.sky.choose(q.rayOrigin(), owenSobol(index, hashCombine(seed, kSkySeed)));
        light.add(scatterChosen(rays, q, sampler, sky, counters));
    }
    return light;
}

// By which chance a path of that throughput went on; 0: it ends. So does one of no number.
float chanceToGoOn(const vec3& throughput, uint32_t index, uint32_t seed) {
    const float chance = std::min(std::max({throughput.x, throughput.y, throughput.z}), kLikeliest);
    return owenSobol(index, hashCombine(seed, kRouletteSeed)).x < chance ? chance : 0.0f;
}

// Radiance that a path brings to its start from where it goes by `first`. Lamps that the first ray
// meets are direct light and do not count.
Brought followPath(const PathContext& context, const Surface& start, const DirectionSample& first,
                   uint32_t index, uint32_t seed, Counters& counters) {
    const RayScene& rays = context.rays;
    const int bounces = context.params.bounces;
    Surface from = start;
    vec3 wi = first.wi;
    float pdf = first.pdf;
    vec3 throughput(1.0f);
    vec3 by_lobes(1.0f);  // of specular surfaces alone
    Brought light;
    // Of a light that the path's ray finds; the first ray's are no caustics.
    const auto add = [&](const vec3& radiance, int bounce) {
        light.all += throughput * radiance;
        light.specular += bounce > 1 ? by_lobes * radiance : vec3(0.0f);
    };
    for (int bounce = 1; opensToward(from, wi); ++bounce) {
        const RayHit hit = nextHit(rays, from, wi, counters);
        throughput *= hit.weight;
        by_lobes *= hit.weight;
        if (!hit.found()) {
            add(skyMet(context.lights, wi, pdf), bounce);
            break;
        }
        const Surface q = rays.surfaceAt(hit, -wi);
        if (bounce > 1) {
            add(lampMet(context.lights, q, hit.triangle, from.rayOrigin(), pdf), bounce);
        }
        if (bounce > bounces) {
            break;
        }
        const BrdfSampler sampler(q.brdf, q.specular_albedo, q.n, q.wo, q.coat);
        const uint32_t bounce_seed = hashCombine(seed, static_cast<uint32_t>(bounce));
        const Scattered here = lightAtVertex(context, q, sampler, index, bounce_seed, counters);
        light.all += throughput * here.all;
        light.specular += by_lobes * here.specular(q.brdf);
        // The last vertex needs one more ray where that may find a lamp or the sky.
        if (bounce == bounces && context.lights.empty()) {
            break;
        }

        // Continue the path from q.
        const DirectionSample next =
            sampleBrdf(sampler, q.brdf, q.n, q.wo, owenSobol(index, bounce_seed));
        if (black(next.weight)) {
            break;
        }
        throughput *= next.weight;
        by_lobes *= Scattered{next.weight, next.diffuse}.specular(q.brdf);
        if (bounces == kAllBounces && bounce > kSureBounces) {
            const float chance = chanceToGoOn(throughput, index, bounce_seed);
            if (chance == 0.0f) {
                break;
            }
            throughput /= chance;
            by_lobes /= chance;
        }
        wi = next.wi;
        pdf = next.pdf;
        from = q;
    }
    return light;
}

}  // namespace

PathSample samplePath(const PathContext& context, const Start& start, const Guide& guide,
                      uint32_t index, uint32_t seed, Counters& counters) {
    const Surface& p = start.p;
    const GuidedPoint guided = guide.warp(owenSobol(index, seed));
    const DirectionSample first = sampleBrdf(start.sampler, p.brdf, p.n, p.wo, guided.u);
    if (context.params.bounces == 0 || black(first.weight)) {
        return {};
    }
    Brought light = followPath(context, p, first, index, seed, counters);
    if (!context.params.caustics_apart) {
        light.specular = vec3(0.0f);
    }
    const vec3 by_lobe = Scattered{first.weight, first.diffuse}.specular(p.brdf);
    const vec3 rest = guided.weight * (light.all - light.specular);
    const vec3 specular = guided.weight * light.specular;
    return {.indirect = {.all = first.weight * rest + by_lobe * specular,
                         .diffuse = first.diffuse * rest},
            .caustic = (first.weight - by_lobe) * specular};
}

Scattered sampleSkyFromStart(const PathContext& context, const Start& start, uint32_t index,
                             uint32_t seed, Counters& counters) {
    if (context.params.bounces == 0 || context.lights.sky.empty()) {
        return {};
    }
    const LightChoice choice = context.lights.sky.choose(
        start.p.rayOrigin(), owenSobol(index, hashCombine(seed, kSkySeed)));
    return scatterChosen(context.rays, start.p, start.sampler, choice, counters);
}

}  // namespace sheen
