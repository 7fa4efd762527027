// Random scenes that are hard on a renderer: rooms and open ground with boxes, spheres, thin walls,
// steps and slivers that touch, nearly touch or interpenetrate, sheared and mirrored, of any
// roughness, lit by lights that may lie close to a surface, seen from anywhere, at any scale.
#pragma once

#include <string>

#include "scene/scene.h"

namespace sheen {

struct StressScene {
    Scene scene;
    std::string what;  ///< one line: what was put together
};

/// The scene of a seed, always the same, on any machine but for rounding.
StressScene stressScene(uint32_t seed);

}  // namespace sheen
