// How light agrees where charts meet.
#pragma once

#include "bake/lightmap.h"

namespace sheen {

/// Root mean squares of the change of luminance from a texel to the next one, at texels of smooth
/// surfaces that have a neighbour in another chart, also in one of another object that touches.
struct Seams {
    int texels = 0;     ///< that have such a neighbour
    double across = 0;  ///< to the nearest one in another chart
    double within = 0;  ///< of the same texels to those beside them in the atlas
};

Seams seamsOf(const Lightmap& map, const Image<vec3>& light);

}  // namespace sheen
