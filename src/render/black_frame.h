// Why an image is black: a user who sees nothing is told what to mend.
#pragma once

#include <string>

#include "image/frame.h"
#include "scene/scene.h"

namespace sheen {

/// One line where the whole frame is black: that the camera is turned away, inside a solid, or
/// where no light comes, and how to mend it. Empty for all other frames, and for scenes without
/// geometry, of which the loader warns.
std::string whyBlack(const Scene& scene, const Camera& camera, const Frame& frame);

}  // namespace sheen
