// What outlives a frame: of a scene what serves all its views, of a view what serves all its
// passes.
#pragma once

#include <optional>

#include "cache/fill.h"
#include "core/ranks.h"
#include "gl/worker_pool.h"
#include "glossy/specular_rays.h"
#include "light/lightmap_light.h"
#include "light/scattered_again.h"
#include "raster/gpu_scene.h"
#include "rays/tracer.h"
#include "receivers/edges.h"
#include "render/render.h"

namespace sheen {

/// Made of a scene once: OpenGL contexts, Embree's tree, its lamps, which lights reach which
/// surfaces, and, for the raster road, the scene and its shadow maps on the GPU.
struct SceneState {
    const Scene& scene;
    const GatherRoad road;
    const gl::Backend backend;
    const RaysWanted rays;
    RankedJob job = {};  // whose ranks gather
    bool specular;       // some surface is
    gl::WorkerPool pool;
    Tracer tracer;
    std::optional<SceneLights> lights;       // always there
    std::optional<ScatteredOnce> outgoing;   // what rays see of one bounce
    std::optional<LightmapLight> lightmaps;  // what they see by Method::kLightmap, with `outgoing`
    GpuScene gpu;                            // empty where records use rays
    std::vector<Bounds> near;  // that cells and shadow maps are made for: empty in most scenes
    /// Light kept on surfaces that serves the next view too, where records do.
    std::shared_ptr<const ScatteredAgain> again;
    KeptBy again_by = KeptBy::kElements;
    int again_photons = 0;
    double again_lacking = 0.0;  ///< near what share of where it was looked for nothing is

    /// Adds up what it took to `seconds`. Environment error without an OpenGL 4.5 context.
    SceneState(const Scene& scene, GatherRoad road, gl::Backend backend, StageSeconds& seconds,
               RaysWanted rays = RaysWanted::kMany);
    ~SceneState();
    /// Whether its caustics are a layer of their own.
    bool keepsCausticsApart(const RenderParams& params) const;
    /// Makes cells and shadow maps for what is near a view (nearBoxes()), unless there are such.
    void prepareFor(const std::vector<Bounds>& boxes, StageSeconds& seconds);
    /// To be called where the scene's lights, or what its materials reflect or emit, changed: makes
    /// what depends on them anew. Rays alone; textures and alpha must stay.
    void relight();
    /// Light of more bounces than one for what is looked for from these receivers. `reuse`: what
    /// was made for a former view, unless it lacks light where this one looks.
    std::shared_ptr<const ScatteredAgain> scatteredAgain(const Receivers& receivers,
                                                         const RenderParams& params, bool reuse);
};

/// What a view is made for: its image, or its records alone, which take less of it.
enum class ViewFor { kImage, kRecords };

/// Made of a camera once: its pixels as receivers, what of their light records are not asked for,
/// and the records gathered so far.
struct ViewState {
    std::shared_ptr<const ScatteredAgain> again;  // none of one bounce; a veil's: its ground's
    const OutgoingLight* outgoing = nullptr;      // what rays see
    Receivers receivers;
    Image<SpecularSeen> specular;  // by rays of the pixels' own; empty where none needs them
    Image<vec3> of_coats;          // indirect light that clear coats add; empty: none
    bool caustics_apart = false;   // records know nothing of them
    Image<vec3> caustic;           // of pixels, edges smoothed; empty where there are none
    size_t caustic_photons = 0;
    std::optional<Edges> edges;          // none where only the pixels' middles count
    Image<SpecularSeen> stray_specular;  // likewise, of the edges' strays
    KeptRecords* const kept;  // of other views, for the first pass to begin with; null: none
    RecordField field;
    Image<vec3> share;  // of each pixel's light; empty: all of it
    int veils = 0;      // blended surfaces before what is seen, each a view of its own

    /// Of what the camera sees behind all blended surfaces; what is `kept`, unless null, must
    /// outlive it. Usage error where the camera does not exist.
    ViewState(SceneState& state, const RenderParams& params, StageSeconds& seconds,
              KeptRecords* kept, ViewFor use = ViewFor::kImage)
        : ViewState(state, params, seconds, 0, nullptr, kept, use) {}
    /// Of the so manieth of these, from 1 on. `ground`, of what is behind them, must outlive it:
    /// rays see the same.
    ViewState(SceneState& state, const RenderParams& params, StageSeconds& seconds, int veil,
              const ViewState& ground)
        : ViewState(state, params, seconds, veil, &ground, nullptr, ViewFor::kImage) {}
    /// Its records are kept for other views.
    ~ViewState();
    ViewState(const ViewState&) = delete;
    ViewState& operator=(const ViewState&) = delete;

  private:
    ViewState(SceneState& state, const RenderParams& params, StageSeconds& seconds, int veil,
              const ViewState* ground, KeptRecords* kept, ViewFor use);
    void findCaustics(const SceneState& state, const RenderParams& params);
};

/// The view's pixels and their direct light, behind all blended surfaces: where indirect light
/// comes from elsewhere. After SceneState::prepareFor().
Receivers directlyLit(SceneState& state, const RenderParams& params, StageSeconds& seconds);

/// What Session::render() makes of its own state. `kept`: as ViewState has it, and of this frame
/// as well afterwards.
RenderResult renderByCache(SceneState& state, const RenderParams& params, KeptRecords* kept);

}  // namespace sheen
