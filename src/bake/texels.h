// Receivers that no one sees: texels of a lightmap, and points that someone asks for. They want
// irradiance alone, of the side that they are put on.
#pragma once

#include "rays/surface_point.h"
#include "receivers/receivers.h"

namespace sheen {

/// Rows of them, none of which lies on a surface yet.
Receivers unseenReceivers(int width, int height);

/// Puts one on a side of a triangle. `normal`: shading normal on that side, unit; `footprint`: the
/// width that it stands for, scene units. Different ones may be put at once.
void putReceiver(Receivers& receivers, size_t i, const Scene& scene, uint32_t triangle,
                 const SurfaceSide& side, const vec3& normal, float footprint);

/// How they are found, and counts them: when all are put.
void indexReceivers(Receivers& receivers, const Scene& scene);

}  // namespace sheen
