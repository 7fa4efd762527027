// What a file without cameras or without light gets, so that it shows something: a camera that
// frames it, and the light of a studio as a photographer would set it.
#pragma once

#include "scene/scene.h"

namespace sheen {

/// Looks at the scene from the front and the side, a little from above, as near as leaves all of it
/// in view in an image that is no higher than wide.
Camera framingCamera(const Scene& scene);

/// The camera that a view of one's own makes of the one it begins with (LoadParams::view).
Camera seenFrom(const Scene& scene, const LoadParams& params);

/// Whether nothing lights the scene: no light, no triangle that emits, no sky, no lightmap.
bool isDark(const Scene& scene);

/// From above, to the left of that camera: fixed in the world, so that other views, animations and
/// bakes share it. White that faces it has radiance 1.
PunctualLight keyLight(const Camera& camera);

/// The surroundings that go with it: neutral grey, soft light from above, a darker floor, one broad
/// soft box where the key light comes from and another one across. Turned to that camera as well.
/// In its shadow white that lies level has a radiance of 0.78.
Environment studioSky(const Camera& camera);

}  // namespace sheen
