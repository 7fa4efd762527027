// Texels without light of their own take that of those around them, so that whoever filters a
// lightmap meets no black.
#pragma once

#include <vector>

#include "bake/lightmap.h"

namespace sheen {

/// First buried texels of a chart, from the nearest ones of the same chart that are not; then all
/// that is left, from what lies around. Without any light all stays as it is.
void dilate(const Lightmap& map, Image<vec3>& light);

}  // namespace sheen
