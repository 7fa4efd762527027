#include "bake/bake.h"

#include <algorithm>
#include <optional>
#include <utility>

#include "bake/bake_light.h"
#include "bake/dilate.h"
#include "cache/fill.h"
#include "core/parallel.h"
#include "core/progress.h"
#include "core/timer.h"
#include "gather/light_around.h"
#include "gather/shared_gather.h"
#include "light/direct.h"
#include "rays/jitter.h"
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

// The same of where it comes from.
void addDirectSh(const Tracer& tracer, const SceneLights& lights, const Receivers& receivers,
                 std::vector<Image<vec3>>& sh) {
    parallelFor(receivers.image.height, [&](int y) {
        for (size_t i = receivers.image.index(0, y); i < receivers.image.index(0, y + 1); ++i) {
            if (!receivers.seen(i)) {
                continue;
            }
            const ShLight light =
                directAround(tracer, lights, receivers.sideAt(tracer.scene(), i), 0.0f,
                             kDirectionalOrder, pcgHash(static_cast<uint32_t>(i)));
            for (size_t k = 0; k < light.size(); ++k) {
                sh[k].pixels[i] += light[k];
            }
        }
    });
}

// Gathered at some texels, interpolated at all.
void byRecords(const Scene& scene, const Receivers& receivers, const BakeParams& params,
               Gatherer& gatherer, Baked& baked) {
    BakeStats& stats = baked.stats;
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
    baked.frame.indirect = std::move(light);
    if (params.directional) {
        baked.sh = splatSh(receivers, placement.cache, how.servingWeight(), kDirectionalOrder);
    }
    stats.seconds_interpolate = interpolate.seconds();
}

// Gathered at every texel.
void byTexels(const Scene& scene, const Receivers& receivers, const BakeParams& params,
              Gatherer& gatherer, Baked& baked) {
    BakeStats& stats = baked.stats;
    Image<vec3> light(receivers.image.width, receivers.image.height);
    constexpr size_t kCoefficients = kDirectionalOrder * kDirectionalOrder;
    if (params.directional) {
        baked.sh.assign(kCoefficients, light);
    }
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
            for (size_t c = 0; c < 3 * baked.sh.size(); ++c) {
                baked.sh[c % kCoefficients].pixels[of[k]][static_cast<int>(c / kCoefficients)] =
                    found[k].sh[c];
            }
        }
        stats.records += static_cast<int>(of.size());
        progress.advance();
    }
    stats.seconds_gather = timer.seconds();
    baked.frame.indirect = std::move(light);
}

// They want of records as many bands as are baked.
Receivers wantingDirections(Receivers receivers) {
    for (int8_t& order : receivers.orders) {
        order = order == kNoOrder ? order : static_cast<int8_t>(kDirectionalOrder);
    }
    return receivers;
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

Baked pageOf(const Atlas& atlas, const Baked& baked, int page) {
    Baked own{.frame = {}, .sh = {}, .stats = baked.stats};
    const Frame& from = baked.frame;
    own.frame.direct = pageOf(atlas, from.direct, page);
    own.frame.indirect = pageOf(atlas, from.indirect, page);
    own.frame.direct_variance = pageOf(atlas, from.direct_variance, page);
    own.frame.indirect_variance = pageOf(atlas, from.indirect_variance, page);
    own.frame.primitive = pageOf(atlas, from.primitive, page);
    own.frame.coverage = pageOf(atlas, from.coverage, page);
    for (const Image<vec3>& coefficient : baked.sh) {
        own.sh.push_back(pageOf(atlas, coefficient, page));
    }
    return own;
}

Baked gatherLight(const Tracer& tracer, const Receivers& given, const BakeParams& params,
                  const RankedJob& job) {
    const Scene& scene = tracer.scene();
    const Receivers of_directions = params.directional ? wantingDirections(given) : Receivers{};
    const Receivers& receivers = params.directional ? of_directions : given;
    Baked baked;
    const Timer made;
    const BakeLight light(tracer, someOf(scene, receivers), params.bounces);
    baked.stats.seconds_lights = made.seconds();
    if (!params.indirect_only) {
        const Timer direct;
        baked.frame.direct = directIrradiance(tracer, light.lights, receivers);
        baked.stats.seconds_direct = direct.seconds();
    }
    const std::unique_ptr<Gatherer> gatherer = light.gatherer(params, job);
    (params.method == BakeMethod::kRecords ? byRecords : byTexels)(scene, receivers, params,
                                                                   *gatherer, baked);
    if (params.directional && !params.indirect_only) {
        const Timer direct;
        addDirectSh(tracer, light.lights, receivers, baked.sh);
        baked.stats.seconds_direct += direct.seconds();
    }
    return baked;
}

void serveBake(const Tracer& tracer, const BakeParams& params, const RankedJob& job) {
    std::optional<BakeLight> light;
    serveGathers(job, [&](const std::string& told) {
        light.emplace(tracer, ByteReader(told), params.bounces);
        return light->gatherer(params.accuracy);
    });
}

Baked bake(const Tracer& tracer, const Lightmap& map, const BakeParams& params,
           const RankedJob& job) {
    Baked baked;
    switch (params.method) {
        case BakeMethod::kRecords:
        case BakeMethod::kTexels:
            baked = gatherLight(tracer, map.receivers, params, job);
            break;
        case BakeMethod::kReference:
            if (params.directional) {
                throwUsage("--directional: --method reference finds irradiance alone");
            }
            if (job.isShared()) {
                throwUsage(
                    "--method reference: where its paths go they learn from those of all texels, "
                    "which cannot be shared out; run it without mpirun");
            }
            bakeByPaths(tracer, map, params, baked);
            break;
    }
    baked.frame.primitive = map.triangles;
    baked.frame.coverage = Image<float>(map.atlas.size, map.atlas.height());
    for (size_t i = 0; i < map.triangles.pixels.size(); ++i) {
        const bool own = map.receivers.seen(i);
        baked.frame.primitive.pixels[i] = own ? map.triangles.pixels[i] : kNoPrimitive;
        baked.frame.coverage.pixels[i] = own ? 1.0f : 0.0f;
    }
    if (baked.frame.direct.empty()) {
        baked.frame.direct = Image<vec3>(map.atlas.size, map.atlas.height());
    }
    dilate(map, baked.frame.direct);
    dilate(map, baked.frame.indirect);
    for (Image<vec3>& coefficient : baked.sh) {
        dilate(map, coefficient);
    }
    return baked;
}

}  // namespace sheen
