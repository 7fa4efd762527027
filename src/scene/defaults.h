// What a file without cameras or without light gets, so that it shows something: a camera that
// frames it, and a key light as a photographer would set it.
#pragma once

#include "scene/scene.h"

namespace sheen {

/// Looks at the centre of the bounds from the front, a little from above, with all of them in view.
Camera framingCamera(const Bounds& bounds);

/// Whether nothing lights the scene: no light, no triangle that emits, no sky.
bool isDark(const Scene& scene);

/// From above, to the left of that camera: fixed in the world, so that other views, animations and
/// bakes share it. White that faces it has radiance 1.
PunctualLight keyLight(const Camera& camera);

}  // namespace sheen
