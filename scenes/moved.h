// Scenes with their first camera and their lights somewhere else: what holds for a scene should not
// hang on where its maker put them.
#pragma once

#include <cstdint>

#include "scenes/model.h"

namespace sheen::scenes {

/// Of a camera's square image, what shows surfaces.
constexpr double kSeenShare = 0.93;

/// The model with its first camera and its lights moved by 2.5 to 5% of the scene's size (the
/// diagonal of its bounds) and turned by 2.5 to 5 degrees; directional lights are only turned. Both
/// stay in the free space they are in, no nearer to any surface than half of what they were, and
/// the same holds for what the camera sees, which is surface in kSeenShare of its image. A seed
/// (at least 1) gives the same everywhere.
Model moved(Model model, uint32_t seed);

}  // namespace sheen::scenes
