#include "render/session.h"

#include <new>

#include "core/parallel.h"
#include "core/timer.h"
#include "light/element_light.h"
#include "light/illumination_cut.h"
#include "light/photon_tracer.h"
#include "light/place_elements.h"
#include "receivers/coats.h"
#include "render/caustics.h"
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

// Each sample of a pixel with edges has had its share already: such pixels' become 1. Returns what
// they were.
Image<vec3> takeWhole(const Edges& edges, Image<vec3>& share) {
    Image<vec3> before = share;
    for (const EdgePixel& edge : edges.pixels) {
        if (!share.empty()) {
            share.pixels[edge.pixel] = vec3(1.0f);
        }
    }
    return before;
}

GBuffer seenBy(const SceneState& state, const RenderParams& params, int veil,
               StageSeconds& seconds) {
    const StageTimer timer(seconds.gbuffer);
    return renderGBuffer(state.tracer, viewOf(state.scene, params), params.width, params.height,
                         veil);
}

// Direct light comes from rays where records use rays, else from shadow maps.
void lightDirectly(SceneState& state, GBuffer& gbuffer, StageSeconds& seconds) {
    const StageTimer timer(seconds.shadow);
    if (state.road == GatherRoad::kRays) {
        gbuffer.direct = directWithCoats(state.tracer, *state.lights, gbuffer);
    } else {
        lightGBuffer(state.pool, state.gpu, gbuffer);
    }
}

Receivers pixelsOf(const SceneState& state, const RenderParams& params, GBuffer gbuffer,
                   StageSeconds& seconds) {
    const StageTimer timer(seconds.gbuffer);
    return receiversOf(state.scene, std::move(gbuffer), params.sh_order,
                       params.method == Method::kIrradiance);
}

// Indirect light of coats, which are seen at pixels' middles alone; empty where there are none.
// `before`: as takeWhole() has it.
Image<vec3> lightOfCoats(const OutgoingLight& light, const std::optional<Receivers>& coats,
                         const SpecularParams& params, const std::optional<Edges>& edges,
                         const Image<vec3>& before) {
    if (!coats || !coats->anyByRays()) {
        return {};
    }
    Image<vec3> reflected = reflectSpecular(*coats, traceSpecular(light, *coats, params), {});
    for (size_t k = 0; edges && !before.empty() && k < edges->pixels.size(); ++k) {
        const size_t pixel = edges->pixels[k].pixel;
        reflected.pixels[pixel] *= before.pixels[pixel];
    }
    return reflected;
}

}  // namespace

SceneState::SceneState(const Scene& scene_, GatherRoad road_, gl::Backend backend_,
                       StageSeconds& seconds, RaysWanted rays_)
    : scene(scene_),
      road(road_),
      backend(backend_),
      rays(rays_),
      specular(anySpecular(scene)),
      // Only the raster gather draws with more than one context.
      pool(road == GatherRoad::kRays ? 1 : threadCount(), threadCount(), backend_),
      tracer(timed(seconds.gather, [&] { return Tracer(scene); })),
      lights(timed(seconds.gather, [&] { return std::make_optional<SceneLights>(tracer); })) {
    if (road == GatherRoad::kRaster) {
        const StageTimer timer(seconds.shadow);
        pool.runOnFirst([&] { gpu = uploadScene(scene); });
    }
}

bool SceneState::keepsCausticsApart(const RenderParams& params) const {
    return specular && params.caustics > 0 && road == GatherRoad::kRays;
}

void SceneState::relight() {
    again.reset();
    lightmaps.reset();
    outgoing.reset();
    near.clear();
    lights.emplace(tracer);
    specular = anySpecular(scene);
}

void SceneState::prepareFor(const std::vector<Bounds>& boxes, StageSeconds& seconds) {
    if (outgoing && near == boxes) {
        return;
    }
    again.reset();
    lightmaps.reset();
    outgoing.reset();  // made last: there are none where anything fails
    near = boxes;
    if (road == GatherRoad::kRaster) {
        const StageTimer timer(seconds.shadow);
        renderShadowMaps(pool, scene, gpu, near);
    }
    const StageTimer timer(seconds.gather);
    // The raster road gathers what lamps send, as light of surfaces.
    outgoing.emplace(tracer, road == GatherRoad::kRays ? &*lights : nullptr, near,
                     rays == RaysWanted::kFew ? LightCells::kLengthForFew : LightCells::kLength);
    if (scene.lightmapped) {
        lightmaps.emplace(*outgoing);
    }
}

std::shared_ptr<const ScatteredAgain> SceneState::scatteredAgain(const Receivers& receivers,
                                                                 const RenderParams& params,
                                                                 bool reuse) {
    const int bounces = params.bounces;
    constexpr double kMoreLacking = 0.03;  // than where it was made for
    const std::vector<ElementSite> from = someOf(scene, receivers);
    if (reuse && again && again->bounces() == bounces && again_by == params.kept_by &&
        again_photons == params.photons &&
        again->lackingShare(from) <= again_lacking + kMoreLacking) {
        return again;
    }
    again.reset();  // never two of them in memory
    std::unique_ptr<const KeptLight> kept;
    if (params.kept_by == KeptBy::kPhotons) {
        kept = std::make_unique<PhotonLight>(tracer, *lights, params.photons, bounces);
    } else {
        kept = std::make_unique<ElementLight>(*outgoing, placeElements(tracer, from), bounces);
    }
    auto made = std::make_shared<const ScatteredAgain>(*outgoing, std::move(kept), near, bounces);
    if (reuse) {
        again = made;
        again_by = params.kept_by;
        again_photons = params.photons;
        again_lacking = made->lackingShare(from);
    }
    return made;
}

SceneState::~SceneState() {
    pool.release([this](int worker) {
        if (worker == 0) {
            gpu = {};
        }
    });
}

Receivers directlyLit(SceneState& state, const RenderParams& params, StageSeconds& seconds) {
    GBuffer gbuffer = seenBy(state, params, 0, seconds);
    lightDirectly(state, gbuffer, seconds);
    return pixelsOf(state, params, std::move(gbuffer), seconds);
}

// rays -> G-buffer -> receivers -> rays where the cache cannot follow.
ViewState::ViewState(SceneState& state, const RenderParams& params, StageSeconds& seconds, int veil,
                     const ViewState* ground, KeptRecords* kept_, ViewFor use)
    : caustics_apart(state.keepsCausticsApart(params)), kept(kept_) {
    GBuffer gbuffer = seenBy(state, params, veil, seconds);
    share = std::move(gbuffer.share);
    veils = gbuffer.veils;
    if (veil == 0) {  // what is prepared for the whole scene serves veils too
        state.prepareFor(nearBoxes(state.scene, gbuffer), seconds);
    }
    const bool of_image = use == ViewFor::kImage;
    if (of_image) {
        lightDirectly(state, gbuffer, seconds);
    }
    std::optional<Receivers> coats;
    if (of_image && state.road == GatherRoad::kRays && !gbuffer.coat.empty() &&
        params.method != Method::kIrradiance) {
        coats = coatsOf(state.scene, gbuffer);
    }
    receivers = pixelsOf(state, params, std::move(gbuffer), seconds);
    Image<vec3> before;
    if (params.aa > 1 && of_image) {
        const StageTimer timer(seconds.gbuffer);
        edges = findEdges(state.tracer, *state.lights, viewOf(state.scene, params), receivers,
                          {veil, share}, params.sh_order, params.aa);
        before = takeWhole(*edges, share);
    }
    checkSplat(state.pool, receivers);
    outgoing = ground != nullptr ? ground->outgoing
               : state.lightmaps ? static_cast<const OutgoingLight*>(&*state.lightmaps)
                                 : &*state.outgoing;
    if (ground != nullptr) {
        again = ground->again;
    } else if (params.bounces > 1) {
        const StageTimer timer(seconds.bounces);
        again = state.scatteredAgain(receivers, params, kept != nullptr);
        outgoing = &*again;
    }
    if (!of_image) {
        return;
    }
    SpecularParams by_rays = params.specular;
    if (caustics_apart) {
        const StageTimer timer(seconds.caustics);
        findCaustics(state, params);
        by_rays.caustics_apart = true;
    }
    const StageTimer timer(seconds.gather);
    of_coats = lightOfCoats(*outgoing, coats, params.specular, edges, before);
    if (receivers.anyByRays()) {
        specular = traceSpecular(*outgoing, receivers, by_rays);
    }
    if (edges && edges->strays.anyByRays()) {
        SpecularParams alone = by_rays;
        alone.pixel_area = false;
        stray_specular = traceSpecular(*outgoing, edges->strays, alone);
    }
}

ViewState::~ViewState() {
    if (kept != nullptr) {
        try {
            kept->put(std::move(field));
        } catch (const std::bad_alloc&) {
            // What memory lacks room for is gathered again.
        }
    }
}

void ViewState::findCaustics(const SceneState& state, const RenderParams& params) {
    const Receivers none;
    const Receivers& strays = edges ? edges->strays : none;
    std::vector<vec3> points;
    for (const Receivers* seen : std::initializer_list<const Receivers*>{&receivers, &strays}) {
        for (size_t i = 0; i < seen->positions.size(); ++i) {
            if (seen->seen(i)) {
                points.push_back(seen->positions[i]);
            }
        }
    }
    const SeenSpace space(points);
    const PhotonMap photons(
        tracePhotons(state.tracer, *state.lights,
                     {.caustics = true, .seen = &space, .bounces = params.bounces},
                     params.caustics),
        space.reach());
    caustic_photons = photons.size();
    const CausticLight of_pixels = causticLight(state.tracer, photons, receivers);
    caustic = causticLayer(receivers, of_pixels);
    if (edges) {
        blendCaustics(*edges, {receivers, of_pixels},
                      {strays, causticLight(state.tracer, photons, strays)}, caustic);
    }
}

}  // namespace sheen
