// Frames whose indirect light radiance hints tell (hints/hints.h): no records, no OpenGL.
#pragma once

#include <optional>

#include "hints/hints.h"
#include "raster/gbuffer.h"
#include "render/render.h"

namespace sheen {

/// What frames by hints are made of; the hints are made and filled by the first of them that finds
/// none.
struct HintSource {
    const Tracer& tracer;
    const SceneLights& lights;
    std::optional<RadianceHints>& hints;
};

/// What lies behind all blended surfaces, lit by hints; adds to the frame and the figures of
/// `result`. Returns what of the G-buffer tells of blended surfaces.
GBuffer renderGroundByHints(const HintSource& source, const RenderParams& params,
                            RenderResult& result);

/// Renders one frame by Method::kHints, blended surfaces among it. Direct light is that of the
/// methods that cache. Usage error where the camera does not exist.
RenderResult renderByHints(const Scene& scene, const RenderParams& params);

}  // namespace sheen
