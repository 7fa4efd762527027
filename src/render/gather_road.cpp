#include "render/gather_road.h"

#include <cmath>

namespace sheen {

// A gather's noise falls with its rays, and the other errors with the accuracy: both together.
// Rays look closer where light changes; a raster cannot (docs/decisions/gather.md).
// A stretched plane has 1.7 times a hemicube's texels a side, for as many in all.
int gatherSize(GatherRoad road, float accuracy, HemisphereKind kind) {
    const float rasterised = kind == HemisphereKind::kBorder ? 41.7f : 24.0f;
    const float texels_at_one = road == GatherRoad::kRays ? 11.4f : rasterised;
    return static_cast<int>(std::lround(texels_at_one / std::sqrt(accuracy)));
}

float gatherExtent(HemisphereKind kind) { return kind == HemisphereKind::kBorder ? 2.5f : 3.0f; }

}  // namespace sheen
