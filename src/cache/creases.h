// Creases: pixels that see the foot of a step about as high as a pixel is wide.
#pragma once

#include <cstdint>

#include "raster/gbuffer.h"

namespace sheen {

/// 1 where something of about the same normal stands in front of a pixel's tangent plane, two
/// pixels away at most: a joint of stones, a moulding. The wall between the two may be too narrow
/// for the image to show it. What it shades is as narrow, so records that lie farther off see it
/// within a texel, and do not know; those on the step are not asked, as it is above their plane.
/// Corners of walls, whose normals differ, are no creases: records see those from far away.
Image<uint8_t> findCreases(const GBuffer& gbuffer);

}  // namespace sheen
