// Direct light by rays.
#pragma once

#include "raster/gbuffer.h"
#include "rays/tracer.h"

namespace sheen {

/// Radiance of direct light that each pixel of the G-buffer scatters toward the camera, a shadow
/// ray from its middle for each light. Black where nothing is seen.
Image<vec3> traceDirect(const Tracer& tracer, const GBuffer& gbuffer);

}  // namespace sheen
