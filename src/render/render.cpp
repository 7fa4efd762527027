#include "render/render.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "baselines/denoise.h"
#include "baselines/irradiance_cache.h"
#include "core/error.h"
#include "core/parallel.h"
#include "core/timer.h"
#include "receivers/classes.h"
#include "render/hints.h"
#include "render/memory_check.h"
#include "render/pass.h"
#include "render/session.h"
#include "render/veils.h"

namespace sheen {
namespace {

void countPixels(RenderResult& result) {
    const Frame& frame = result.frame;
    const Image<vec3> seen = beauty(frame);
    for (size_t i = 0; i < seen.pixels.size(); ++i) {
        result.stats.nonfinite_pixels += finite(seen.pixels[i]) ? 0 : 1;
        result.stats.pixels_geometry += frame.primitive.pixels[i] == kNoPrimitive ? 0 : 1;
    }
}

// Fewer replicates stratify better: at 64 paths four have three quarters of the variance of
// sixteen, which know the variance better.
int replicatesFor(int spp) { return spp < 1024 ? 4 : 16; }

RenderResult renderByPaths(const Scene& scene, const RenderParams& params) {
    ReferenceResult traced = renderReference(
        scene, {.width = params.width,
                .height = params.height,
                .camera = viewOf(scene, params),
                .bounces = params.bounces,
                .spp = params.spp,
                .replicates = replicatesFor(params.spp),
                .pixel_area = params.aa > 1,
                .caustics_apart = params.caustics > 0 && params.method == Method::kReference,
                .seed = params.seed,
                .quiet = params.quiet});
    RenderResult result;
    result.stats.seconds.trace = traced.seconds;
    result.stats.mrays_per_second = traced.mrays_per_second;
    result.stats.spp = traced.spp;
    if (params.method == Method::kDenoised) {
        const Timer denoise_timer;
        denoise(traced);
        result.stats.seconds.denoise = denoise_timer.seconds();
    }
    result.frame = std::move(traced.frame);
    countPixels(result);
    return result;
}

RenderResult renderByOctree(const Scene& scene, const RenderParams& params) {
    IrradianceCacheResult cached =
        renderIrradianceCache(scene, {.width = params.width,
                                      .height = params.height,
                                      .camera = viewOf(scene, params),
                                      .accuracy = params.placement.accuracy,
                                      .rings = params.gather.size,
                                      .quiet = params.quiet});
    RenderResult result;
    result.frame = std::move(cached.frame);
    result.stats.records = cached.records;
    result.stats.pixels_uncovered = cached.uncovered;
    result.stats.seconds.gbuffer = cached.see;
    result.stats.seconds.placement = cached.place;
    result.stats.seconds.gather = cached.gather;
    result.stats.seconds.splat = cached.interpolate;
    countPixels(result);
    return result;
}

std::vector<MaterialOrder> nameOrders(const Scene& scene, const std::vector<int>& orders) {
    std::vector<MaterialOrder> named;
    for (size_t i = 0; i < scene.materials.size(); ++i) {
        named.push_back({scene.materials[i].name, orders[i]});
    }
    return named;
}

// Renders at finer and finer accuracies, until the estimate is at most the target or falls no more.
void renderToTarget(const RenderParams& params, SceneState& state, ViewState& view,
                    RenderResult& result) {
    constexpr float kUsualAtPercent = 0.3f;  // accuracy that most scenes take for an error of 1%,
                                             // and not quite as fine
    constexpr float kFinestFirst = 0.25f;    // a target may be out of reach
    // The error falls like this power of the accuracy, until what records do not cause is left:
    // from the first pass on its power is then small (docs/decisions/placement.md).
    constexpr double kUsualPower = 0.7;
    constexpr double kLeastPower = 0.25;
    constexpr float kTelling = 0.35f;    // over less of the first accuracy chance hides it
    constexpr double kStep = 1.0 / 3.0;  // farther ahead little is known
    constexpr double kMargin = 0.85;     // a pass that just misses is lost
    const float first =
        std::clamp(kUsualAtPercent *
                       static_cast<float>(std::pow(100.0 * params.target_error, 1.0 / kUsualPower)),
                   kFinestFirst, 1.0f);
    double of_first = 0.0;
    for (float accuracy = first;;) {
        renderPass(params, {.accuracy = accuracy}, state, view, result);
        const double estimate = result.stats.estimate_high;
        of_first = accuracy == first ? result.stats.estimated_rel_rmse : of_first;
        const bool falls =
            accuracy > kTelling * first ||
            result.stats.estimated_rel_rmse < of_first * std::pow(accuracy / first, kLeastPower);
        if (!(estimate > params.target_error) || accuracy <= kFinestAccuracy || !falls) {
            return;
        }
        const double factor = std::pow(kMargin * params.target_error / estimate, 1.0 / kUsualPower);
        accuracy =
            std::max(accuracy * static_cast<float>(std::max(factor, kStep)), kFinestAccuracy);
    }
}

// Renders at finer and finer accuracies, as long as another pass is expected to end in time; one
// that does not is given up.
void renderInTime(const RenderParams& params, const Timer& timer, SceneState& state,
                  ViewState& view, RenderResult& result) {
    constexpr float kFirst = 2.0f;
    constexpr double kStep = 1.0 / 4.0;   // farther ahead little is known
    constexpr double kWorthwhile = 0.85;  // a smaller gain in accuracy does not show
    constexpr double kMargin = 0.85;      // of the time there is
    // The number of records, and the time of a pass, go with these powers of one over the accuracy
    // (docs/decisions/placement.md).
    constexpr double kRecordsPower = 1.3;
    constexpr double kTimePower = 1.7;
    const StageSeconds& seconds = result.stats.seconds;
    for (Pass pass{.accuracy = kFirst};;) {
        const Timer pass_timer;
        const double before = seconds.splat + seconds.compose;
        try {
            renderPass(params, pass, state, view, result);
        } catch (const OutOfTime&) {
            return;
        }
        const double afterwards = seconds.splat + seconds.compose - before;
        const double left = params.time_limit - timer.seconds();
        const double factor =
            std::max(std::pow(pass_timer.seconds() / (kMargin * left), 1.0 / kTimePower), kStep);
        const bool lit = std::isfinite(result.stats.estimated_rel_rmse);
        if (!(left > 0.0 && factor < kWorthwhile && lit) || pass.accuracy <= kFinestAccuracy) {
            return;
        }
        pass.accuracy = std::max(pass.accuracy * static_cast<float>(factor), kFinestAccuracy);
        pass.seconds = left - afterwards * std::pow(factor, -kRecordsPower);
    }
}

void renderView(const RenderParams& params, const Timer& timer, SceneState& state, ViewState& view,
                RenderResult& result) {
    if (params.method == Method::kLightmap) {
        renderLightmaps(params, state.scene, view, result);
    } else if (params.target_error > 0.0) {
        renderToTarget(params, state, view, result);
    } else if (params.time_limit > 0.0) {
        renderInTime(params, timer, state, view, result);
    } else {
        renderPass(params, {.accuracy = params.placement.accuracy}, state, view, result);
    }
}

// `made_in`: what making the state took, from `timer`'s begin on.
RenderResult renderStateByCache(SceneState& state, const StageSeconds& made_in,
                                const RenderParams& params, const Timer& timer, KeptRecords* kept) {
    RenderResult result;
    RenderStats& stats = result.stats;
    stats.seconds = made_in;
    ViewState view(state, params, stats.seconds, kept);
    RenderParams each = params;
    each.time_limit /= view.veils + 1;
    renderView(each, timer, state, view, result);
    VeiledFrame veiled(result, view.share);
    for (int veil = 1; veil <= view.veils; ++veil) {
        RenderResult of_veil;
        of_veil.stats.seconds = stats.seconds;
        ViewState veil_view(state, params, of_veil.stats.seconds, veil, view);
        each.time_limit += params.time_limit / (view.veils + 1);
        renderView(each, timer, state, veil_view, of_veil);
        veiled.add(std::move(of_veil), veil_view.share);
    }
    countPixels(result);
    stats.gl_renderer = state.pool.renderer();
    const ReceiverCounts& counts = view.receivers.counts;
    const double seen = std::max(counts.seen, 1);
    stats.diffuse_share = counts.diffuse / seen;
    stats.corrected_share = counts.corrected / seen;
    stats.too_glossy_share = counts.too_glossy / seen;
    if (params.method != Method::kLightmap) {
        stats.sh_order = nameOrders(state.scene, view.receivers.material_orders);
    }
    stats.caustic_photons = view.caustic_photons;
    if (view.again) {
        stats.elements = view.again->keptCount();
        stats.elements_missed_share = view.again->missedShare();
    }
    return result;
}

}  // namespace

RenderResult renderByCache(SceneState& state, const RenderParams& params, KeptRecords* kept) {
    return renderStateByCache(state, {}, params, Timer(), kept);
}

std::string recordRecipe(const RenderParams& params) {
    return fmt::format(
        "method {}, order {}, road {}, hemisphere {} of extent {}, bounces {}{}, caustics apart {}",
        params.method == Method::kIrradiance ? "irradiance" : "radiance", params.sh_order,
        params.gather_road == GatherRoad::kRays ? "rays" : "raster",
        static_cast<int>(params.gather.kind), params.gather.extent, params.bounces,
        params.kept_by == KeptBy::kPhotons && params.bounces > 1
            ? fmt::format(" by {} photons", params.photons)
            : "",
        params.caustics > 0);
}

Camera viewOf(const Scene& scene, const RenderParams& params) {
    Camera camera = params.view ? *params.view : findCamera(scene, params.camera);
    camera.window = params.window;
    return camera;
}

bool usesCache(Method method) {
    return method == Method::kRadiance || method == Method::kIrradiance;
}

bool smoothsEdges(Method method, GatherRoad road) {
    switch (method) {
        case Method::kReference:
            return true;
        case Method::kRadiance:
        case Method::kIrradiance:
        case Method::kLightmap:
            return road == GatherRoad::kRays;
        case Method::kOctree:
        case Method::kDenoised:
        case Method::kHints:
            return false;
    }
    throw std::logic_error("unknown method");
}

bool findsCaustics(Method method, GatherRoad road) {
    return method != Method::kDenoised && method != Method::kLightmap && smoothsEdges(method, road);
}

Session::Session(const Scene& scene, RankedJob job, RaysWanted rays)
    : scene_(scene), job_(std::move(job)), rays_(rays) {}
Session::~Session() = default;

void Session::keepRecords(KeptRecords records, std::string recipe) {
    keeps_ = true;
    kept_ = std::move(records);
    recipe_ = std::move(recipe);
}

KeptRecords* Session::keptFor(const RenderParams& params) {
    if (!keeps_) {
        return nullptr;
    }
    std::string recipe = recordRecipe(params);
    if (recipe != recipe_) {
        kept_ = {};
        recipe_ = std::move(recipe);
    }
    return &kept_;
}

SceneState& Session::stateFor(const RenderParams& params, StageSeconds& seconds) {
    viewOf(scene_, params);  // before anything is made for it
    if (!state_ || state_->road != params.gather_road || state_->backend != params.gl) {
        state_.reset();  // never two of them in memory
        state_ =
            std::make_unique<SceneState>(scene_, params.gather_road, params.gl, seconds, rays_);
        state_->job = job_;
    }
    return *state_;
}

RenderResult Session::renderByState(const RenderParams& params, const Timer& timer,
                                    KeptRecords* kept) {
    StageSeconds seconds;
    SceneState& state = stateFor(params, seconds);
    RenderParams smoothed = params;
    smoothed.specular.pixel_area = params.aa > 1;
    return renderStateByCache(state, seconds, smoothed, timer, kept);
}

RenderStats Session::gather(const RenderParams& params) {
    SHEEN_CHECK(keeps_ && usesCache(params.method));
    check(params);
    const Timer timer;
    RenderStats stats;
    SceneState& state = stateFor(params, stats.seconds);
    {
        // Whose end hands its records over.
        ViewState view(state, params, stats.seconds, keptFor(params), ViewFor::kRecords);
        gatherPass(params, {.accuracy = params.placement.accuracy}, state, view, stats);
    }
    stats.seconds.total = timer.seconds();
    return stats;
}

RenderResult Session::renderByMethod(const RenderParams& params) {
    const Timer timer;
    switch (params.method) {
        case Method::kReference:
        case Method::kDenoised:
            return renderByPaths(scene_, params);
        case Method::kOctree:
            return renderByOctree(scene_, params);
        case Method::kHints: {
            RenderResult result = renderByHints(scene_, params);
            countPixels(result);
            return result;
        }
        case Method::kLightmap: {
            // What lightmaps lack is found by rays, and has been scattered often enough.
            RenderParams by_rays = params;
            by_rays.sh_order = kLobesByRays;
            by_rays.bounces = 1;
            by_rays.caustics = 0;
            return renderByState(by_rays, timer, nullptr);
        }
        case Method::kRadiance:
        case Method::kIrradiance:
            return renderByState(params, timer, keptFor(params));
    }
    throw std::logic_error("unknown method");
}

void Session::check(const RenderParams& params) const {
    if (params.aa > 1 && !smoothsEdges(params.method, params.gather_road)) {
        throwUsage(
            "--aa {}: only radiance and irradiance by rays, and reference, see more of a pixel "
            "than its middle; use --aa 1",
            params.aa);
    }
    if (params.target_error > 0.0 && params.kept_by == KeptBy::kPhotons && params.bounces > 1) {
        throwUsage(
            "--target-error: light that is kept by photons errs by up to 8%, whatever records do; "
            "use --kept-by elements");
    }
    if ((params.method == Method::kLightmap) != scene_.lightmapped) {
        throwUsage("{}",
                   scene_.lightmapped
                       ? "--method: the scene is loaded to be seen by its lightmaps alone"
                       : "--method lightmap: the scene has no lightmaps (MOZ_lightmap) for all "
                         "its surfaces, or is loaded without them; sheen bake makes some");
    }
    if (usesCache(params.method) && params.gather_road == GatherRoad::kRaster) {
        if (!scene_.environment.empty()) {
            throwUsage(
                "--gather: records that are rasterised see no sky; use --gather ray, or "
                "--environment none");
        }
        if (params.bounces != 1) {
            throwUsage("--bounces: records that are rasterised have 1; use --gather ray");
        }
    }
    checkRenderMemory(scene_, params);
}

RenderResult Session::render(const RenderParams& params) {
    check(params);
    RenderResult result = renderByMethod(params);
    result.frame.shows_sky = scene_.environment.shows();
    // Users know the file's coordinates alone.
    for (size_t i = 0; i < result.frame.position.pixels.size(); ++i) {
        if (result.frame.primitive.pixels[i] != kNoPrimitive) {
            vec3& position = result.frame.position.pixels[i];
            position = vec3(scene_.inFile(position));
        }
    }
    return result;
}

RenderResult renderFrame(const Scene& scene, const RenderParams& params) {
    return Session(scene).render(params);
}

}  // namespace sheen
