// The C++ twin of the shaders' scene functions: BRDF, lights, textures.
#pragma once

#include <glm/glm.hpp>

namespace sheen::shared {
using namespace glm;

#include "shared/brdf.glsl"
#include "shared/light.glsl"
#include "shared/texture.glsl"

}  // namespace sheen::shared
