#include "render/session.h"

#include "core/parallel.h"
#include "core/timer.h"
#include "light/place_elements.h"
#include "rays/jitter.h"
#include "receivers/coats.h"
#include "splat/splat.h"

namespace sheen {
namespace {

// Adds the time until its end to a stage.
class StageTimer {
  public:
    explicit StageTimer(double& stage) : stage_(stage) {}
    ~StageTimer() { stage_ += timer_.seconds(); }
    StageTimer(const StageTimer&) = delete;
    StageTimer& operator=(const StageTimer&) = delete;

  private:
    double& stage_;
    Timer timer_;
};

template <class Make>
auto timed(double& stage, const Make& make) {
    const StageTimer timer(stage);
    return make();
}

// About a thousand receivers, by chance.
std::vector<ElementSite> someOf(const Scene& scene, const Receivers& receivers) {
    constexpr double kSome = 1024.0;
    const double share = kSome / std::max(receivers.counts.seen, 1);
    std::vector<ElementSite> some;
    for (size_t i = 0; i < receivers.positions.size(); ++i) {
        if (receivers.seen(i) && pcgHash(static_cast<uint32_t>(i)) * 0x1p-32 < share) {
            some.push_back({.side = receivers.sideAt(scene, i), .normal = receivers.normals[i]});
        }
    }
    return some;
}

}  // namespace

SceneState::SceneState(const Scene& scene_, GatherRoad road_, StageSeconds& seconds)
    : scene(scene_),
      road(road_),
      // Only the raster gather draws with more than one context.
      pool(road == GatherRoad::kRays ? 1 : threadCount(), threadCount()),
      tracer(timed(seconds.gather, [&] { return Tracer(scene); })),
      lights(timed(seconds.gather, [&] { return SceneLights(tracer); })) {
    if (road == GatherRoad::kRaster) {
        const StageTimer timer(seconds.shadow);
        pool.runOnFirst([&] { gpu = uploadScene(scene); });
    }
}

void SceneState::prepareFor(const std::vector<Bounds>& boxes, StageSeconds& seconds) {
    if (outgoing && near == boxes) {
        return;
    }
    outgoing.reset();  // made last: there are none where anything fails
    near = boxes;
    if (road == GatherRoad::kRaster) {
        const StageTimer timer(seconds.shadow);
        renderShadowMaps(pool, scene, gpu, near);
    }
    const StageTimer timer(seconds.gather);
    // The raster road gathers what lamps send, as light of surfaces.
    outgoing.emplace(tracer, road == GatherRoad::kRays ? &lights : nullptr, near);
}

SceneState::~SceneState() {
    pool.release([this](int worker) {
        if (worker == 0) {
            gpu = {};
        }
    });
}

// rays -> G-buffer -> receivers -> rays where the cache cannot follow. Direct light comes from rays
// where records use rays, else from shadow maps.
ViewState::ViewState(SceneState& state, const RenderParams& params, StageSeconds& seconds, int veil,
                     const ViewState* ground) {
    std::optional<Receivers> coats;
    const Camera camera = viewOf(state.scene, params);
    GBuffer gbuffer = timed(seconds.gbuffer, [&] {
        return renderGBuffer(state.tracer, camera, params.width, params.height, veil);
    });
    share = std::move(gbuffer.share);
    veils = gbuffer.veils;
    if (veil == 0) {  // what is prepared for the whole scene serves veils too
        state.prepareFor(nearBoxes(state.scene, gbuffer), seconds);
    }
    {
        const StageTimer timer(seconds.shadow);
        if (state.road == GatherRoad::kRays) {
            gbuffer.direct = directWithCoats(state.tracer, state.lights, gbuffer);
            if (!gbuffer.coat.empty() && params.method == Method::kRadiance) {
                coats = coatsOf(state.scene, gbuffer);
            }
        } else {
            lightGBuffer(state.pool, state.gpu, gbuffer);
        }
    }
    receivers = timed(seconds.gbuffer, [&] {
        return receiversOf(state.scene, std::move(gbuffer), params.sh_order,
                           params.method == Method::kIrradiance);
    });
    if (params.aa > 1) {
        const StageTimer timer(seconds.gbuffer);
        edges = findEdges(state.tracer, state.lights, camera, receivers, {veil, share},
                          params.sh_order, params.aa);
        for (const EdgePixel& edge : edges->pixels) {
            if (!share.empty()) {
                share.pixels[edge.pixel] = 1.0f;  // each sample had its own
            }
        }
    }
    checkSplat(state.pool, receivers);
    outgoing = ground != nullptr ? ground->outgoing : &*state.outgoing;
    if (params.bounces > 1 && ground == nullptr) {
        const StageTimer timer(seconds.bounces);
        again.emplace(*state.outgoing, placeElements(state.tracer, someOf(state.scene, receivers)),
                      state.near, params.bounces);
        outgoing = &*again;
    }
    const StageTimer timer(seconds.gather);
    if (coats && coats->anyByRays()) {
        of_coats = reflectSpecular(*coats, traceSpecular(*outgoing, *coats, params.specular), {});
    }
    if (receivers.anyByRays()) {
        specular = traceSpecular(*outgoing, receivers, params.specular);
    }
    if (edges && edges->strays.anyByRays()) {
        SpecularParams alone = params.specular;
        alone.pixel_area = false;
        stray_specular = traceSpecular(*outgoing, edges->strays, alone);
    }
}

}  // namespace sheen
