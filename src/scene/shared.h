// The C++ twin of the shaders' scene functions: BRDF, lights, texture taps.
#pragma once

#include <glm/glm.hpp>

namespace sheen::shared {
using namespace glm;

#include "shared/brdf.glsl"
#include "shared/light.glsl"

}  // namespace sheen::shared
