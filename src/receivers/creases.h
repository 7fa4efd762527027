// Creases: receivers at the foot of a step about as high as a pixel is wide.
#pragma once

#include <cstdint>
#include <vector>

#include "receivers/receivers.h"

namespace sheen {

/// [receiver]: 1 where something of about the same normal stands in front of its tangent plane, two
/// pixels away at most: a joint of stones, a moulding. The wall between the two may be too narrow
/// for the image to show it. What it shades is as narrow, so records that lie farther off see it
/// within a texel, and do not know; those on the step are not asked, as it is above their plane.
/// Corners of walls, whose normals differ, are no creases: records see those from far away.
std::vector<uint8_t> findCreases(const Receivers& receivers);

}  // namespace sheen
