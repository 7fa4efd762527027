// Light at points that a caller of the library hands over.
#pragma once

#include "library/requests.h"
#include "scene/scene.h"

namespace sheen::library {

/// Fills `direct` and `indirect`, [point][3], either of which may be null; warns of points that lie
/// on no surface, whose light is NaN. Usage error for points that cannot be.
void askPoints(const Scene& scene, const sheen_points& points, const Request& request,
               float* direct, float* indirect);

}  // namespace sheen::library
