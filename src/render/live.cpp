#include "render/live.h"

#include <algorithm>
#include <limits>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "cache/scan.h"
#include "core/error.h"
#include "core/parallel.h"
#include "core/timer.h"
#include "render/hints.h"
#include "render/memory_check.h"
#include "render/pass.h"
#include "splat/upsample.h"

namespace sheen {
namespace {

// Of the coarsest image: so many of the whole one's pixels are one of its, along a side.
constexpr int kCoarsest = 8;
// An image that stands is shown so seldom that gathering takes so many times what showing does.
constexpr double kFillOverShow = 2.0;
constexpr int kFinest = 2;  // of images of views that move
// Records beyond those that a view sees: some hundred megabytes at the most.
constexpr size_t kMostKept = 100'000;
// Sites gathered at a time: few, so that a step ends in time.
constexpr int kBatch = 16;
// Of each volume: few, since they only stand in for records.
constexpr int kHints = 2048;
// Rays of a pixel too glossy for the cache before the image is complete, over those that it then
// has.
constexpr float kFewRays = 0.1f;

bool isServed(const SplatBuffer& splat, size_t i) {
    return splat.irradiance.pixels[i].w > shared::MIN_WEIGHT_SUM;
}

int countUnserved(const Receivers& receivers, const SplatBuffer& splat) {
    int count = 0;
    for (size_t i = 0; i < receivers.positions.size(); ++i) {
        count += receivers.seen(i) && !isServed(splat, i) ? 1 : 0;
    }
    return count;
}

// Receivers that no record serves have what hints say of them.
void serveByHints(const Receivers& receivers, const HintLight& hinted, SplatBuffer& splat) {
    for (size_t i = 0; i < receivers.positions.size(); ++i) {
        if (!receivers.seen(i) || isServed(splat, i)) {
            continue;
        }
        splat.irradiance.pixels[i] = vec4(hinted.irradiance[i], 1.0f);
        if (receivers.orders[i] > shared::DIFFUSE_ORDER && !splat.specular.empty()) {
            const vec3 scale = glm::max(receivers.lobes.scale[i], vec3(1e-12f));
            splat.specular.pixels[i] = vec4(hinted.reflected[i] / scale, 0.0f);
        }
    }
}

// Images of up to so many pixels are splatted by the processor, whose time is about that of
// software OpenGL there, and less below.
constexpr size_t kFewPixels = size_t{160} * 160;

// The size that the next view begins with, where this one's beginning took so many times the time
// there was for it, gathering apart.
int nextSize(int divisor, double took) {
    constexpr double kMuch = 1.5, kLittle = 0.4;
    return took > kMuch     ? std::min(2 * divisor, kCoarsest)
           : took < kLittle ? std::max(divisor / 2, kFinest)
                            : divisor;
}

// What a coarse view's light is shown on: twice as many pixels along a side, of which each has
// direct light and surfaces of its own.
struct FinerPixels {
    Receivers receivers;
    Upsampling upsampling;

    FinerPixels(Receivers receivers_, const Receivers& coarse)
        : receivers(std::move(receivers_)), upsampling(coarse, receivers) {}
    FinerPixels(const FinerPixels&) = delete;
    FinerPixels& operator=(const FinerPixels&) = delete;
};

// A view at one size, while records are placed for it.
struct Level {
    const RenderParams params;
    const PlacementParams how;
    ViewState view;
    std::unique_ptr<Gatherer> gatherer;
    PlacedRecords placed;
    Scan scan;
    const size_t began_with;  // records
    bool full = false;
    std::optional<HintLight> hinted;   // what its pixels get before records serve them
    std::optional<FinerPixels> finer;  // that are shown; none: its own

    // `shown`: of the pixels that are shown.
    Level(SceneState& state, const RenderParams& params_, const RenderParams& shown,
          KeptRecords* kept, StageSeconds& seconds)
        : params(params_),
          how(howOf(params_)),
          view(state, params_, seconds, kept),
          gatherer(prepare(state)),
          placed(state.scene, view.receivers, how, view.field),
          scan(view.receivers, how, view.field.records.empty(), true),
          began_with(view.field.records.size()) {
        if (shown.width > params.width || shown.height > params.height) {
            finer.emplace(directlyLit(state, shown, seconds), view.receivers);
        }
    }

    const Receivers& shownPixels() const { return finer ? finer->receivers : view.receivers; }
    // What the shown pixels reflect of what the level's own receive.
    Frame compose(SplatBuffer splat) const {
        Image<vec3> by_rays = specularByRays(view, splat, full);
        Image<vec3> of_coats = view.of_coats;
        if (finer) {
            Upsampling::Light light = finer->upsampling.of(splat, by_rays);
            splat = std::move(light.splat);
            by_rays = std::move(light.by_rays);
            of_coats = of_coats.empty() ? Image<vec3>() : finer->upsampling.of(of_coats);
        }
        Frame frame;
        sheen::compose(shownPixels(), splat, by_rays, true, frame);
        for (size_t i = 0; i < of_coats.pixels.size(); ++i) {
            frame.indirect.pixels[i] += of_coats.pixels[i];
        }
        return frame;
    }
    static PlacementParams howOf(const RenderParams& params) {
        PlacementParams how = placementOf(params, params.placement.accuracy);
        how.batch = kBatch;
        return how;
    }
    std::unique_ptr<Gatherer> prepare(SceneState& state) {
        const HemisphereParams hemisphere = hemisphereOf(params.gather, state.road, how.accuracy);
        prepareField(view, how, hemisphere.size, true);
        return makeGatherer(state, view, hemisphere);
    }
};

}  // namespace

struct LiveImage::State {
    Scene scene;
    RenderParams params;
    std::string recipe;
    std::unique_ptr<SceneState> built;
    std::optional<RadianceHints> hints;
    KeptRecords kept;
    std::unique_ptr<Level> level;
    int divisor = kCoarsest;  // of the level
    int begin_at = kCoarsest;
    bool changed = true;
    bool shown = false;         // whether the frame is that of the level as it is
    double show_seconds = 0.0;  // what showing took last
    Frame frame;
    LiveProgress progress;
    RecordCache cache;  // that the frame is by
    WeightParams weight{};
    Image<float> orders;

    void forget() {
        level.reset();
        kept = {};
        cache = {};
    }
    RenderParams paramsOf(int of_divisor) const {
        RenderParams p = params;
        p.width = std::max(params.width / of_divisor, 1);
        p.height = std::max(params.height / of_divisor, 1);
        p.aa = 1;
        p.specular.rays_per_alpha *= kFewRays;
        return p;
    }
    void begin(int at) {
        level.reset();  // its records are kept
        divisor = at;
        shown = false;
        level = std::make_unique<Level>(*built, paramsOf(at), paramsOf(std::max(at / 2, 1)), &kept,
                                        progress.seconds);
        kept.dropToLatest(kMostKept);
    }
    RenderParams paramsOfWhole() const {
        RenderParams p = params;
        p.all_layers = true;
        p.specular.pixel_area = p.aa > 1;
        return p;
    }
    // `began`: something has changed since the last one.
    void step(bool began, double seconds);
    // Where there are no records yet: a frame by hints alone, at once. Whether it was one.
    bool beginByHints();
    // Places records until about so many seconds of the timer, once at the least, and shows what
    // there is. How long the placing took.
    double fill(const Timer& timer, double seconds);
    void show();
    void finish();
};

LiveImage::LiveImage(Scene scene, const RenderParams& params) : s_(std::make_unique<State>()) {
    s_->scene = std::move(scene);
    const Camera seen = viewOf(s_->scene, params);
    s_->scene.cameras.push_back(seen);
    setParams(params);
}

LiveImage::~LiveImage() = default;

const Scene& LiveImage::scene() const { return s_->scene; }
const RenderParams& LiveImage::params() const { return s_->params; }
const Camera& LiveImage::camera() const { return s_->scene.cameras.back(); }
const Frame& LiveImage::frame() const { return s_->frame; }
const LiveProgress& LiveImage::progress() const { return s_->progress; }

std::vector<LiveMark> LiveImage::marks() const {
    std::vector<LiveMark> marks;
    for (const Record& k : s_->cache.records) {
        marks.push_back({k.position, k.normal, s_->weight.accuracy * k.radius, k.order});
    }
    return marks;
}

std::optional<PixelParts> LiveImage::partsAt(const vec2& place) const {
    const State& s = *s_;
    const bool inside = place.x >= 0.0f && place.y >= 0.0f && place.x < 1.0f && place.y < 1.0f;
    if (!s.built || !s.built->outgoing || s.orders.empty() || !inside) {
        return std::nullopt;
    }
    const auto pixelOf = [&](int width, int height) {
        const vec2 size(width, height);
        return ivec2(glm::min(place * size, size - 1.0f));
    };
    const ivec2 coarse = pixelOf(s.orders.width, s.orders.height);
    const int order = std::max(static_cast<int>(s.orders.at(coarse.x, coarse.y)), 0);
    PixelParts parts = partsOf(*s.built, s.params, pixelOf(s.params.width, s.params.height), order,
                               s.cache, s.weight);
    const ivec2 shown = pixelOf(s.frame.width(), s.frame.height());
    const auto in = [&](const Image<vec3>& layer) {
        return layer.empty() ? vec3(0.0f) : layer.at(shown.x, shown.y);
    };
    parts.direct = in(s.frame.direct);
    parts.indirect = in(s.frame.indirect);
    parts.caustic = in(s.frame.caustic);
    parts.emission = in(s.frame.emission);
    return parts;
}

const Image<float>& LiveImage::orders() const { return s_->orders; }
bool LiveImage::done() const { return !s_->changed && s_->progress.complete; }

void LiveImage::look(const Camera& camera) {
    s_->scene.cameras.back() = camera;
    s_->params.view = camera;
    s_->changed = true;
}

void LiveImage::setParams(const RenderParams& params) {
    const bool cached = params.method == Method::kRadiance || params.method == Method::kIrradiance;
    if (!cached || params.gather_road != GatherRoad::kRays) {
        throwUsage("--method: what is looked at live is radiance or irradiance by rays");
    }
    RenderParams wanted = params;
    wanted.all_layers = true;  // as it is once it is complete
    checkRenderMemory(s_->scene, wanted);
    wanted.all_layers = params.all_layers;
    wanted.quiet = true;
    // Photons belong to a view, and would be traced again for each.
    wanted.caustics = 0;
    wanted.camera.clear();
    wanted.view = s_->scene.cameras.back();
    const std::string recipe = recordRecipe(wanted);
    if (recipe != s_->recipe) {
        s_->forget();
        s_->hints.reset();
        s_->recipe = recipe;
    }
    s_->params = wanted;
    s_->changed = true;
}

void LiveImage::edit(const std::function<void(Scene&)>& change) {
    s_->forget();
    s_->hints.reset();
    change(s_->scene);
    if (s_->built) {
        s_->built->relight();
    }
    s_->changed = true;
}

bool LiveImage::step(double seconds, const std::atomic<bool>* outdated) {
    if (done()) {
        return false;
    }
    const bool changed = std::exchange(s_->changed, false);
    s_->progress.complete = false;
    try {
        std::optional<StopScope> stop;
        if (outdated != nullptr && !changed) {
            stop.emplace(*outdated);
        }
        s_->step(changed, seconds);
        return true;
    } catch (const Stopped&) {
        s_->level.reset();
        s_->changed = true;
        return false;
    } catch (...) {
        s_->level.reset();
        s_->changed = true;  // it begins anew
        throw;
    }
}

void LiveImage::State::step(bool began, double seconds) {
    const Timer timer;
    progress.seconds = {};
    if (!began && level && level->full && divisor == 1) {
        finish();
    } else {
        if (began && beginByHints()) {
            progress.seconds.total = timer.seconds();
            return;
        }
        if (began || !level) {
            begin(begin_at);
        } else if (level->full) {
            begin(divisor / 2);
        }
        // What moves is shown in time: with as many new records as the rest of it allows.
        const double filled = fill(timer, began ? seconds - show_seconds
                                                : std::max(seconds, kFillOverShow * show_seconds));
        if (began) {
            begin_at = nextSize(begin_at, (timer.seconds() - filled) / seconds);
        }
    }
    progress.seconds.total = timer.seconds();
}

bool LiveImage::State::beginByHints() {
    if (!built) {
        built =
            std::make_unique<SceneState>(scene, params.gather_road, params.gl, progress.seconds);
    }
    if (level || kept.size() > 0) {
        return false;
    }
    RenderParams p = paramsOf(begin_at);
    p.all_layers = true;
    p.hints = kHints;
    p.sh_order = 0;  // their own
    RenderResult result;
    renderGroundByHints({built->tracer, *built->lights, hints}, p, result);
    frame = std::move(result.frame);
    frame.shows_sky = scene.environment.shows();
    orders = Image<float>(p.width, p.height);
    cache = {};
    progress = {.width = p.width,
                .height = p.height,
                .uncovered = result.stats.pixels_uncovered,
                .seconds = result.stats.seconds};
    return true;
}

double LiveImage::State::fill(const Timer& timer, double seconds) {
    const GatherSeconds before = level->gatherer->seconds();
    const Timer fill_timer;
    while (!level->full) {
        level->full =
            !fillOnce(scene, level->placed, level->scan, *level->gatherer, level->view.field);
        shown = false;
        if (timer.seconds() >= seconds) {
            break;
        }
    }
    const GatherSeconds after = level->gatherer->seconds();
    progress.seconds.gather += after.see - before.see;
    progress.seconds.project += after.project - before.project;
    const double took = fill_timer.seconds();
    progress.seconds.placement +=
        took - (after.see - before.see) - (after.project - before.project);
    if (!shown) {
        show();
    }
    return took;
}

// What a level leaves out: edges, surfaces that light passes, an estimate of the error.
void LiveImage::State::finish() {
    level.reset();
    RenderResult result = renderByCache(*built, paramsOfWhole(), &kept);
    frame = std::move(result.frame);
    frame.shows_sky = scene.environment.shows();
    progress.seconds = result.stats.seconds;
    progress.records = result.stats.records;
    progress.records_new = result.stats.records - result.stats.records_reused;
    progress.estimated_rel_rmse = result.stats.estimated_rel_rmse;
    progress.complete = true;
}

// Changes nothing before all is done that may be stopped.
void LiveImage::State::show() {
    const Timer show_timer;
    RecordCache served = level->placed.handOver();
    const WeightParams serving = level->how.servingWeight();
    const Timer splat_timer;
    const Receivers& receivers = level->view.receivers;
    SplatBuffer splat = receivers.positions.size() <= kFewPixels
                            ? splatCpu(receivers, served, serving)
                            : splatView(*built, level->view, served, serving);
    const int unserved = level->full ? 0 : countUnserved(receivers, splat);
    if (unserved > 0 && hints) {
        if (!level->hinted) {
            level->hinted = hints->at(receivers);
        }
        serveByHints(receivers, *level->hinted, splat);
    }
    progress.seconds.splat += splat_timer.seconds();
    const Timer compose_timer;
    Frame made = level->compose(std::move(splat));
    made.shows_sky = scene.environment.shows();
    progress.seconds.compose += compose_timer.seconds();

    const Receivers& seen = level->shownPixels();
    frame = std::move(made);
    cache = std::move(served);
    weight = serving;
    orders = Image<float>(frame.width(), frame.height());
    for (size_t i = 0; i < orders.pixels.size(); ++i) {
        orders.pixels[i] = std::max(static_cast<float>(seen.orders[i]), 0.0f);
    }
    progress.width = frame.width();
    progress.height = frame.height();
    progress.uncovered = unserved * (seen.image.count() / receivers.image.count());
    progress.records = static_cast<int>(cache.records.size());
    progress.records_new = static_cast<int>(level->view.field.records.size() - level->began_with);
    progress.estimated_rel_rmse = std::numeric_limits<double>::quiet_NaN();
    show_seconds = show_timer.seconds();
    shown = true;
}

}  // namespace sheen
