// Whether there is memory for an image, asked before it is begun.
#pragma once

#include "render/render.h"

namespace sheen {

/// Environment error where the frame would take more than there is.
void checkRenderMemory(const Scene& scene, const RenderParams& params);

}  // namespace sheen
