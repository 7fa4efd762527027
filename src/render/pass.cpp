#include "render/pass.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "cache/estimate.h"
#include "cache/probes.h"
#include "cache/temporal.h"
#include "core/timer.h"
#include "gather/raster_gather.h"
#include "gather/ray_gather.h"
#include "gather/shared_gather.h"
#include "gl/objects.h"
#include "render/shared_frame.h"

namespace sheen {
namespace {

// The software rasteriser keeps what it last drew to, deleted or not, until it draws elsewhere.
void dropTargets() {
    const gl::Texture texel = gl::makeTexture2d(GL_RGBA32F, 1, 1);
    const GLuint name = texel.name();
    const gl::Framebuffer target = gl::makeFramebuffer({&name, 1}, 0);
    const float black[4] = {};
    gl::glClearNamedFramebufferfv(target.name(), GL_COLOR, 0, black);
    gl::glFinish();
}

}  // namespace

HemisphereParams hemisphereOf(const HemisphereParams& wanted, GatherRoad road, float accuracy) {
    HemisphereParams hemisphere = wanted;
    if (hemisphere.size == 0) {
        hemisphere.size = gatherSize(road, accuracy, hemisphere.kind);
    }
    if (hemisphere.extent == 0.0f) {
        hemisphere.extent = gatherExtent(hemisphere.kind);
    }
    return hemisphere;
}

PlacementParams placementOf(const RenderParams& params, float accuracy) {
    PlacementParams how = params.placement;
    how.accuracy = accuracy;
    if (how.min_pixels == 0.0f) {
        how.min_pixels = leastReach(accuracy);
    }
    return how;
}

void prepareField(ViewState& view, const PlacementParams& how, int gather_size, bool first) {
    constexpr float kMuchCoarser = 0.7f;
    if (view.kept != nullptr && first) {
        view.field = view.kept->take(view.receivers, how);
    }
    if (static_cast<float>(view.field.gather_size) <
        kMuchCoarser * static_cast<float>(gather_size)) {
        view.field = {};
        view.field.gather_size = gather_size;
    }
}

std::unique_ptr<Gatherer> makeGatherer(SceneState& state, const ViewState& view,
                                       const HemisphereParams& hemisphere) {
    switch (state.road) {
        case GatherRoad::kRays:
            return gatherByAll(
                std::make_unique<RayGatherer>(*view.outgoing, hemisphere, view.caustics_apart),
                state.job, [&] { return toldOf(state, view, hemisphere); });
        case GatherRoad::kRaster:
            return std::make_unique<RasterGatherer>(state.pool, state.gpu, hemisphere);
    }
    throw std::logic_error("unknown road");
}

SplatBuffer splatView(SceneState& state, const ViewState& view, const RecordCache& cache,
                      const WeightParams& weight) {
    SplatBuffer splat = splatGpu(state.pool, view.receivers, cache, weight);
    splatBent(view.receivers, cache, weight, splat);
    state.pool.runOnFirst(dropTargets);
    return splat;
}

Image<vec3> specularByRays(const ViewState& view, const SplatBuffer& splat, bool filtered) {
    if (view.specular.pixels.empty()) {
        return {};
    }
    return reflectSpecular(view.receivers, view.specular, cachedSpecular(view.receivers, splat),
                           filtered);
}

namespace {

// What is expected of each judged pixel, for those around it too.
Image<float> errorLayer(const Image<float>& squares) {
    Image<float> layer(squares.width, squares.height);
    for (int y = 0; y < layer.height; ++y) {
        for (int x = 0; x < layer.width; ++x) {
            layer.at(x, y) = std::sqrt(squares.at(x - x % 2, y - y % 2));
        }
    }
    return layer;
}

// How wrong the image is: by the records, and by probes, which cast rays whatever road the records
// took. Probes cost a twentieth of the records, up to what is enough. `layer`: Frame::error, unless
// null.
ErrorEstimate judge(const SceneState& state, const RenderParams& params, const ViewState& view,
                    const RecordCache& cache, const WeightParams& weight,
                    const HemisphereParams& hemisphere, const Image<vec3>& indirect,
                    Image<float>* layer) {
    constexpr size_t kRecordsPerProbe = 40;
    constexpr size_t kFewest = 32;
    constexpr size_t kEnough = 400;
    const NeighbourErrors errors =
        neighbourErrors(view.receivers, cache, view.field.pixels, weight, indirect);
    if (layer != nullptr && !errors.squares.empty()) {
        *layer = errorLayer(errors.squares);
    }
    std::vector<Probe> probes = chooseProbes(
        errors, view.receivers, indirect,
        static_cast<int>(std::clamp(cache.records.size() / kRecordsPerProbe, kFewest, kEnough)));
    HemisphereParams seen = hemisphere;
    seen.kind = HemisphereKind::kHemicube;
    if (state.road != GatherRoad::kRays) {
        seen.size = gatherSize(GatherRoad::kRays, params.placement.accuracy);
    }
    SpecularParams specular = params.specular;
    specular.caustics_apart = view.caustics_apart;
    RayGatherer gatherer(*view.outgoing, seen, view.caustics_apart);
    gatherProbes(state.scene, view.receivers, view.field, gatherer, *view.outgoing, specular,
                 probes);
    return estimateError(errors, probes, view.receivers, indirect);
}

// What the illumination cut gets wrong all records share, and none tells of: as much is added as
// was measured (docs/decisions/light.md), at the most where the estimate is high.
void addErrorOfCut(ErrorEstimate& estimate) {
    constexpr double kUsual = 0.05, kMost = 0.08;
    estimate.rel_rmse = std::hypot(estimate.rel_rmse, kUsual);
    estimate.high = std::hypot(estimate.high, kMost);
}

// Gathers anew where records have ended, places what is missing, and adds what that took to the
// stages' seconds, also where it takes too long.
Placement placeTimed(SceneState& state, ViewState& view, const PlacementParams& how,
                     const HemisphereParams& hemisphere, bool quiet, double at_most,
                     RenderStats& stats) {
    StageSeconds& seconds = stats.seconds;
    const std::unique_ptr<Gatherer> gatherer = makeGatherer(state, view, hemisphere);
    const Timer timer;
    const auto account = [&] {
        const GatherSeconds gathered = gatherer->seconds();
        seconds.gather += gathered.see;
        seconds.project += gathered.project;
        seconds.placement += timer.seconds() - gathered.see - gathered.project;
    };
    const Ageing* ageing = view.kept != nullptr ? view.kept->ageing() : nullptr;
    if (ageing != nullptr && ageing->coming) {
        gatherer->lookAheadBy(*ageing->coming);
    }
    const bool follows = ageing != nullptr && ageing->anchors != nullptr;
    if (follows) {
        gatherer->keepStrata(*ageing->anchors);
    }
    try {
        if (ageing != nullptr) {
            stats.records_renewed += static_cast<int>(
                renew(state.scene, view.receivers, how, *ageing, *gatherer, view.field));
        }
        const size_t known = view.field.records.size();
        Placement placement =
            placeRecords(state.scene, view.receivers, how, *gatherer, view.field, quiet, at_most);
        if (ageing != nullptr && !follows) {
            beginLives(view.field, known, ageing->params, known == 0);
        }
        account();
        return placement;
    } catch (const OutOfTime&) {
        account();
        throw;
    }
}

// Gives receivers that no record serves records of their own: strays of edges, and pixels that a
// record was placed for which does not serve them, since what records were placed by is wider
// across the surface (servingWeight()). So many.
int serveMissed(SceneState& state, const ViewState& view, const Receivers& receivers,
                const PlacementParams& how, const HemisphereParams& hemisphere,
                SplatBuffer& splat) {
    std::vector<size_t> missed;
    for (size_t i = 0; i < splat.irradiance.pixels.size(); ++i) {
        if (receivers.orders[i] != kNoOrder &&
            splat.irradiance.pixels[i].w <= shared::MIN_WEIGHT_SUM) {
            missed.push_back(i);
        }
    }
    if (missed.empty()) {
        return 0;
    }
    const std::unique_ptr<Gatherer> gatherer = makeGatherer(state, view, hemisphere);
    const RecordCache own = recordsAt(state.scene, receivers, missed, how, *gatherer);
    const SplatBuffer by_own = splatCpu(receivers, own, how.servingWeight());
    const auto take = [&](Image<vec4>& all, const Image<vec4>& own_says) {
        for (const size_t i : missed) {
            if (!all.pixels.empty()) {  // one that nothing is said in is empty
                all.pixels[i] = own_says.pixels.empty() ? vec4(0.0f) : own_says.pixels[i];
            }
        }
    };
    take(splat.irradiance, by_own.irradiance);
    take(splat.specular, by_own.specular);
    take(splat.missed, by_own.missed);
    return static_cast<int>(missed.size());
}

// What samples of edges see, for what their pixels' middles do; `splat`: of the strays.
ComposeCounts smoothEdges(const ViewState& view, const SplatBuffer& splat,
                          const LitReceivers& pixels, RenderResult& result) {
    const Receivers& strays = view.edges->strays;
    Image<vec3> specular;
    if (!view.stray_specular.pixels.empty()) {
        specular =
            reflectSpecular(strays, view.stray_specular, cachedSpecular(strays, splat), false);
    }
    result.stats.pixels_edges = static_cast<int>(view.edges->pixels.size());
    return blendEdges(*view.edges, pixels, {strays, splat, specular}, result.frame);
}

void addCoats(const ViewState& view, Frame& frame) {
    for (size_t i = 0; i < view.of_coats.pixels.size(); ++i) {
        frame.indirect.pixels[i] += view.of_coats.pixels[i];
    }
}

void tell(const Placement& placement, const ErrorEstimate& estimate, const ComposeCounts& counts,
          RenderStats& stats) {
    stats.records = static_cast<int>(placement.cache.records.size());
    stats.estimated_rel_rmse = estimate.rel_rmse;
    stats.estimate_low = estimate.low;
    stats.estimate_high = estimate.high;
    stats.passes += 1;
    stats.pixels_uncovered = placement.uncovered;
    stats.nonfinite_pixels = counts.nonfinite;
    stats.negative_pixels = counts.negative;
}

}  // namespace

void renderLightmaps(const RenderParams& params, const Scene& scene, const ViewState& view,
                     RenderResult& result) {
    StageSeconds& seconds = result.stats.seconds;
    const Timer splat_timer;
    const SplatBuffer splat = splatLightmaps(scene, view.receivers);
    seconds.splat += splat_timer.seconds();
    const Timer compose_timer;
    const Image<vec3> specular = specularByRays(view, splat);
    ComposeCounts counts =
        compose(view.receivers, splat, specular, params.all_layers, result.frame);
    if (view.edges) {
        const SplatBuffer of_strays = splatLightmaps(scene, view.edges->strays);
        counts.add(smoothEdges(view, of_strays, {view.receivers, splat, specular}, result));
    }
    addCoats(view, result.frame);
    result.frame.weight = {};  // there are no records
    result.stats.nonfinite_pixels = counts.nonfinite;
    result.stats.negative_pixels = counts.negative;
    seconds.compose += compose_timer.seconds();
}

void gatherPass(const RenderParams& params, const Pass& pass, SceneState& state, ViewState& view,
                RenderStats& stats) {
    const PlacementParams how = placementOf(params, pass.accuracy);
    const HemisphereParams hemisphere = hemisphereOf(params.gather, state.road, pass.accuracy);
    prepareField(view, how, hemisphere.size, true);
    const Placement placement =
        placeTimed(state, view, how, hemisphere, params.quiet, pass.seconds, stats);
    stats.records = static_cast<int>(placement.cache.records.size());
    stats.records_reused = static_cast<int>(view.field.reused);
}

void renderPass(const RenderParams& params, const Pass& pass, SceneState& state, ViewState& view,
                RenderResult& result) {
    const PlacementParams how = placementOf(params, pass.accuracy);
    const HemisphereParams hemisphere = hemisphereOf(params.gather, state.road, pass.accuracy);

    RenderStats& stats = result.stats;
    StageSeconds& seconds = stats.seconds;
    prepareField(view, how, hemisphere.size, stats.passes == 0);
    const Placement placement =
        placeTimed(state, view, how, hemisphere, params.quiet, pass.seconds, stats);

    const Timer splat_timer;
    SplatBuffer splat = splatView(state, view, placement.cache, how.servingWeight());
    const int apart = serveMissed(state, view, view.receivers, how, hemisphere, splat);
    seconds.splat += splat_timer.seconds();

    const Timer compose_timer;
    Image<vec3> specular = specularByRays(view, splat);
    ComposeCounts counts =
        compose(view.receivers, splat, specular, params.all_layers, result.frame);
    if (!view.edges) {
        splat = {};
        specular = {};
    }
    ErrorEstimate estimate = judge(
        state, params, view, placement.cache, how.servingWeight(), hemisphere,
        view.receivers.irradiance_only ? result.frame.indirect_diffuse : result.frame.indirect,
        params.all_layers ? &result.frame.error : nullptr);
    if (params.bounces > 1 && params.kept_by == KeptBy::kPhotons) {
        addErrorOfCut(estimate);
    }
    if (view.edges) {
        SplatBuffer of_strays = splatCpu(view.edges->strays, placement.cache, how.servingWeight());
        stats.edge_records =
            serveMissed(state, view, view.edges->strays, how, hemisphere, of_strays);
        counts.add(smoothEdges(view, of_strays, {view.receivers, splat, specular}, result));
    }
    result.frame.caustic = view.caustic;
    addCoats(view, result.frame);
    if (params.all_layers) {
        result.frame.records = countRecords(view.receivers, placement.cache, how.servingWeight());
    }
    seconds.compose += compose_timer.seconds();

    stats.accuracy = pass.accuracy;
    stats.gather_size = hemisphere.size;
    tell(placement, estimate, counts, stats);
    stats.records += apart;
    stats.records_reused = static_cast<int>(view.field.reused);
    stats.records_of_clusters = static_cast<int>(view.field.of_clusters);
}

}  // namespace sheen
