// The two roads by which records find the light around them, and how finely each looks; measured in
// docs/decisions/gather.md.
#pragma once

#include "hemisphere/hemisphere.h"

namespace sheen {

/// What finds the light around a record: rays on the CPU or the rasteriser.
enum class GatherRoad { kRays, kRaster };

/// Texels along a hemisphere's side where none are asked for.
int gatherSize(GatherRoad road, float accuracy, HemisphereKind kind = HemisphereKind::kHemicube);
/// Half-extent of a hemisphere's plane where none is asked for.
float gatherExtent(HemisphereKind kind);

}  // namespace sheen
