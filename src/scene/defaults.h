// What a file without cameras or without light gets, so that it shows something: a camera that
// frames it, and the light of a studio as a photographer would set it.
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

/// The surroundings that go with it: neutral grey, soft light from above, a darker floor, one broad
/// soft box where the key light comes from and another one across. Turned to that camera as well.
/// In its shadow white that lies level has a radiance of 0.78.
Environment studioSky(const Camera& camera);

}  // namespace sheen
