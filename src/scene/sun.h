// A sun in an image of the sky: a few texels with much of its light. Sampled as part of the image
// it rings in what is kept of the sky and makes noise, so it becomes a directional light.
#pragma once

#include <optional>

#include "scene/environment.h"
#include "scene/shared.h"

namespace sheen {

/// The sun of `environment` as a light that brings the same irradiance to a surface facing it, and
/// takes it out of the image: its texels become as bright as those around it. None where no bright
/// place smaller than four degrees across holds a fifth of the sky's light.
std::optional<shared::PunctualLight> takeOutSun(Environment& environment);

}  // namespace sheen
