// One frame by several processes: the first rank sees, places, splats and composes; all gather.
#pragma once

#include <string>

#include "core/ranks.h"
#include "render/session.h"

namespace sheen {

/// What other ranks make their gatherers of (serveFrame()): the light that the view's rays see, and
/// how they look.
std::string toldOf(const SceneState& state, const ViewState& view,
                   const HemisphereParams& hemisphere);

/// Usage error where the frame cannot be shared out over several ranks.
void checkShared(const RenderParams& params);

/// On other ranks than the first: gathers what a Session of that job asks for, which renders the
/// scene by these parameters, until the first rank ends.
void serveFrame(const Scene& scene, const RenderParams& params, const RankedJob& job);

}  // namespace sheen
