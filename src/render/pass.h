// One pass over a view: records are placed, splatted, and what pixels reflect of their light
// composed. Also its steps, for those who take them one by one.
#pragma once

#include <memory>

#include "render/session.h"
#include "splat/splat.h"

namespace sheen {

/// What decides what a pass renders: its accuracy, and when it is given up.
struct Pass {
    float accuracy = 0;
    double seconds = kInfinity;  ///< for gathering; OutOfTime is thrown where that is not enough
};

/// Places, gathers, splats, composes and judges. A pass that is given up has changed nothing of
/// `result` but times.
void renderPass(const RenderParams& params, const Pass& pass, SceneState& state, ViewState& view,
                RenderResult& result);

/// Places and gathers alone. Errors as renderPass().
void gatherPass(const RenderParams& params, const Pass& pass, SceneState& state, ViewState& view,
                RenderStats& stats);

/// The same of light that the scene's lightmaps hold, which must be lightmapped: no records, and no
/// estimate.
void renderLightmaps(const RenderParams& params, const Scene& scene, const ViewState& view,
                     RenderResult& result);

/// What a pass gathers with where the user has not said.
HemisphereParams hemisphereOf(const HemisphereParams& wanted, GatherRoad road, float accuracy);
/// How it places.
PlacementParams placementOf(const RenderParams& params, float accuracy);
/// Begins the view's field: with what is kept for it, where this is the `first` pass, and without
/// records of much fewer rays, which would spoil what the others find.
void prepareField(ViewState& view, const PlacementParams& how, int gather_size, bool first);
/// What gathers for a view, which must outlive it.
std::unique_ptr<Gatherer> makeGatherer(SceneState& state, const ViewState& view,
                                       const HemisphereParams& hemisphere);
/// Sums of records over the view's pixels.
SplatBuffer splatView(SceneState& state, const ViewState& view, const RecordCache& cache,
                      const WeightParams& weight);
/// What lobes reflect that rays see for, with what records say of them; empty where none does.
/// `filtered`: without the rays' noise, which takes longer.
Image<vec3> specularByRays(const ViewState& view, const SplatBuffer& splat, bool filtered = true);

}  // namespace sheen
