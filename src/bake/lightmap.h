// The texels of a lightmap as receivers: where on its surface each takes its light.
#pragma once

#include <vector>

#include "bake/atlas.h"
#include "image/image.h"
#include "rays/tracer.h"
#include "receivers/receivers.h"

namespace sheen {

struct Lightmap {
    Atlas atlas;
    /// [texel], row by row and page by page: those without a triangle, and those that are buried,
    /// are not seen().
    Receivers receivers;
    /// That the texel belongs to, buried or not; kNoPrimitive: to none.
    Image<uint32_t> triangles;
    int covered = 0;  ///< texels that a triangle touches
    int buried = 0;   ///< of these, all of which lies within something solid
    int pushed = 0;  ///< of these, whose middle does, so that another point of theirs stands for it
};

/// Every texel that a triangle touches gets a point: its middle, or what of the triangle is nearest
/// to that. A point that lies within a solid (solids.h) gives way to another one of the same texel
/// and triangle that does not, if there is one.
Lightmap lightmapOf(const Tracer& tracer, Atlas atlas);

}  // namespace sheen
