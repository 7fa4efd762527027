// Frames whose indirect light radiance hints tell (hints/hints.h): no records, no OpenGL.
#pragma once

#include "render/render.h"

namespace sheen {

/// Renders one frame by Method::kHints, blended surfaces among it. Direct light is that of the
/// methods that cache. Usage error where the camera does not exist.
RenderResult renderByHints(const Scene& scene, const RenderParams& params);

}  // namespace sheen
