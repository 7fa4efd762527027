// Direct light by rays.
#pragma once

#include "light/scene_lights.h"
#include "raster/gbuffer.h"
#include "rays/tracer.h"

namespace sheen {

/// Radiance of direct light that each pixel of the G-buffer scatters toward the camera: of punctual
/// lights by a shadow ray from its middle to each, where there are many to some (ManyLights); of
/// lamps by samples (lampLight()). Black where nothing is seen. `rows_of`: as lampLight() has it.
Image<vec3> traceDirect(const Tracer& tracer, const SceneLights& lights, const GBuffer& gbuffer,
                        std::span<const uint32_t> rows_of = {});

}  // namespace sheen
