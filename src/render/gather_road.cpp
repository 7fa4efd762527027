#include "render/gather_road.h"

#include <cmath>

namespace sheen {

// A gather's noise falls with its rays, and the other errors with the accuracy: both together.
// Rays look closer where light changes; a raster cannot (docs/decisions.md).
int gatherSize(GatherRoad road, float accuracy) {
    const float texels_at_one = road == GatherRoad::kRays ? 11.4f : 24.0f;
    return static_cast<int>(std::lround(texels_at_one / std::sqrt(accuracy)));
}

double RecordCost::milliseconds(int triangles) const {
    return fixed + factor * std::pow(static_cast<double>(triangles), power);
}

RoadChoice cheaperRoad(const RoadCosts& costs, int triangles) {
    const double ratio = costs.raster_equal_error * costs.raster.milliseconds(triangles) /
                         costs.rays.milliseconds(triangles);
    return {ratio < 1.0 ? GatherRoad::kRaster : GatherRoad::kRays, ratio};
}

}  // namespace sheen
