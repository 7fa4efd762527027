// A standing woman without arms, draped from the hips down, after the Venus of Melos: about 24,000
// triangles with curvature at every scale, folds, and surfaces close to each other.
#pragma once

#include "scenes/model.h"

namespace sheen::scenes {

/// Stands on y = 0 (its base reaches 2 cm below) around the y axis, faces +z, 1.85 m high with its
/// base; positions and normals.
Mesh statue();

}  // namespace sheen::scenes
