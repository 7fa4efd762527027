#include "bake/bake.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "bake/dilate.h"
#include "cache/fill.h"
#include "core/progress.h"
#include "core/timer.h"
#include "gather/ray_gather.h"
#include "gather/shared_gather.h"
#include "light/direct.h"
#include "light/element_light.h"
#include "light/place_elements.h"
#include "light/scattered_again.h"
#include "reference/reference.h"
#include "render/gather_road.h"
#include "splat/splat.h"

namespace sheen {
namespace {

// White and dull: what it scatters is its irradiance over pi.
Scatterer whiteAt(const Receivers& receivers, size_t i) {
    return {.n = receivers.normals[i],
            .brdf = {.diffuse = vec3(1.0f), .alpha = 1.0f, .f0 = vec3(0.0f), .f90 = 0.0f}};
}

// What arrives straight from lights and lamps.
Image<vec3> directIrradiance(const Tracer& tracer, const SceneLights& lights,
                             const Receivers& receivers) {
    const PixelGrid& grid = receivers.image;
    Image<vec3> direct =
        traceDirect(tracer, lights, {grid.width, grid.height}, {},
                    [&](int x, int y) -> std::optional<LitPoint> {
                        const size_t i = grid.index(x, y);
                        if (!receivers.seen(i)) {
                            return std::nullopt;
                        }
                        return LitPoint{.side = receivers.sideAt(tracer.scene(), i),
                                        .surface = whiteAt(receivers, i)};
                    });
    for (vec3& light : direct.pixels) {
        light *= kPi;
    }
    return direct;
}

PlacementParams placementFor(float accuracy) {
    PlacementParams how;
    how.accuracy = accuracy;
    how.min_pixels = leastReach(accuracy);
    return how;
}

// Gathered at some texels, interpolated at all.
Image<vec3> byRecords(const Scene& scene, const Receivers& receivers, const BakeParams& params,
                      Gatherer& gatherer, BakeStats& stats) {
    const PlacementParams how = placementFor(params.accuracy);
    RecordField field;
    const Timer place;
    const Placement placement = placeRecords(scene, receivers, how, gatherer, field, params.quiet);
    const GatherSeconds gathered = gatherer.seconds();
    stats.seconds_gather = gathered.see + gathered.project;
    stats.seconds_place = place.seconds() - stats.seconds_gather;
    stats.records = static_cast<int>(field.records.size());
    stats.uncovered = placement.uncovered;
    const Timer interpolate;
    const SplatBuffer sums = splatCpu(receivers, placement.cache, how.servingWeight());
    Image<vec3> light(receivers.image.width, receivers.image.height);
    for (size_t i = 0; i < light.pixels.size(); ++i) {
        const vec4& sum = sums.irradiance.pixels[i];
        light.pixels[i] = sum.w > 0.0f ? vec3(sum) / sum.w : vec3(0.0f);
    }
    stats.seconds_interpolate = interpolate.seconds();
    return light;
}

// Gathered at every texel.
Image<vec3> byTexels(const Scene& scene, const Receivers& receivers, const BakeParams& params,
                     Gatherer& gatherer, BakeStats& stats) {
    Image<vec3> light(receivers.image.width, receivers.image.height);
    Progress progress("gathering at every texel", light.height, params.quiet);
    const Timer timer;
    for (int y = 0; y < light.height; ++y) {
        std::vector<RecordSite> sites;
        std::vector<size_t> of;
        for (int x = 0; x < light.width; ++x) {
            const size_t i = receivers.image.index(x, y);
            if (receivers.seen(i)) {
                sites.push_back(siteAt(scene, receivers, i));
                of.push_back(i);
            }
        }
        const std::vector<GatheredRecord> found = gatherer.gather(sites);
        for (size_t k = 0; k < of.size(); ++k) {
            light.pixels[of[k]] = found[k].record.irradiance;
        }
        stats.records += static_cast<int>(of.size());
        progress.advance();
    }
    stats.seconds_gather = timer.seconds();
    return light;
}

void bakeByPaths(const Tracer& tracer, const Lightmap& map, const BakeParams& params,
                 Baked& baked) {
    constexpr int kReplicates = 4;
    const Receivers& receivers = map.receivers;
    const auto surface_of = [&](int x, int y) -> std::optional<Surface> {
        const size_t i = receivers.image.index(x, y);
        if (!receivers.seen(i)) {
            return std::nullopt;
        }
        const SurfaceSide side = receivers.sideAt(tracer.scene(), i);
        return Surface{.position = side.position,
                       .n_g = side.n_g,
                       .n = receivers.normals[i],
                       .wo = side.toward_viewer,
                       .brdf = whiteAt(receivers, i).brdf,
                       .coat = std::nullopt,
                       .roughness = 1.0f,
                       .offset = 2.0f * side.offset};
    };
    ReferenceResult traced = renderReferenceOf(tracer.scene(),
                                               {.width = receivers.image.width,
                                                .height = receivers.image.height,
                                                .camera = {},
                                                .bounces = params.bounces,
                                                .spp = params.spp,
                                                .replicates = kReplicates,
                                                .seed = params.seed,
                                                .quiet = params.quiet},
                                               surface_of);
    const auto scale = [](Image<vec3>& image, float factor) {
        for (vec3& value : image.pixels) {
            value *= factor;
        }
    };
    scale(traced.frame.indirect, kPi);
    scale(traced.frame.indirect_variance, kPi * kPi);
    baked.frame.indirect = std::move(traced.frame.indirect);
    baked.frame.indirect_variance = std::move(traced.frame.indirect_variance);
    if (!params.indirect_only) {
        scale(traced.frame.direct, kPi);
        scale(traced.frame.direct_variance, kPi * kPi);
        baked.frame.direct = std::move(traced.frame.direct);
        baked.frame.direct_variance = std::move(traced.frame.direct_variance);
    }
    baked.stats.seconds_trace = traced.seconds;
    baked.stats.spp = traced.spp;
}

}  // namespace

Baked gatherLight(const Tracer& tracer, const Receivers& receivers, const BakeParams& params,
                  const RankedJob& job) {
    const Scene& scene = tracer.scene();
    Baked baked;
    const Timer made;
    const SceneLights lights(tracer);
    const ScatteredOnce once(tracer, &lights, std::vector<Bounds>{});
    std::optional<ScatteredAgain> again;
    if (params.bounces > 1) {
        again.emplace(once,
                      std::make_unique<ElementLight>(
                          once, placeElements(tracer, someOf(scene, receivers)), params.bounces),
                      std::vector<Bounds>{}, params.bounces);
    }
    baked.stats.seconds_lights = made.seconds();
    if (!params.indirect_only && job.first()) {
        const Timer direct;
        baked.frame.direct = directIrradiance(tracer, lights, receivers);
        baked.stats.seconds_direct = direct.seconds();
    }
    const OutgoingLight& outgoing = again ? static_cast<const OutgoingLight&>(*again) : once;
    RayGatherer own(outgoing, {.size = gatherSize(GatherRoad::kRays, params.accuracy)});
    if (!job.first()) {
        serveGather(own, job);
        return baked;
    }
    SharedGatherer shared(own, job);
    Gatherer& gatherer = job.isShared() ? static_cast<Gatherer&>(shared) : own;
    baked.frame.indirect = params.method == BakeMethod::kRecords
                               ? byRecords(scene, receivers, params, gatherer, baked.stats)
                               : byTexels(scene, receivers, params, gatherer, baked.stats);
    return baked;
}

Baked bake(const Tracer& tracer, const Lightmap& map, const BakeParams& params,
           const RankedJob& job) {
    const int size = map.atlas.size;
    Baked baked;
    switch (params.method) {
        case BakeMethod::kRecords:
        case BakeMethod::kTexels:
            baked = gatherLight(tracer, map.receivers, params, job);
            break;
        case BakeMethod::kReference:
            if (job.isShared()) {
                throwUsage(
                    "--method reference: where its paths go they learn from those of all texels, "
                    "which cannot be shared out; run it without mpirun");
            }
            bakeByPaths(tracer, map, params, baked);
            break;
    }
    if (!job.first()) {
        return baked;
    }
    baked.frame.primitive = map.triangles;
    baked.frame.coverage = Image<float>(size, size);
    for (size_t i = 0; i < map.triangles.pixels.size(); ++i) {
        const bool own = map.receivers.seen(i);
        baked.frame.primitive.pixels[i] = own ? map.triangles.pixels[i] : kNoPrimitive;
        baked.frame.coverage.pixels[i] = own ? 1.0f : 0.0f;
    }
    if (baked.frame.direct.empty()) {
        baked.frame.direct = Image<vec3>(size, size);
    }
    dilate(map, baked.frame.direct);
    dilate(map, baked.frame.indirect);
    return baked;
}

}  // namespace sheen
