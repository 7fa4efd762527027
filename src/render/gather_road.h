// The two roads by which records find the light around them: how finely each looks, and which costs
// less. Chosen before anything is rendered (`--gather auto`); measured in docs/decisions.md.
#pragma once

#include "hemisphere/hemisphere.h"

namespace sheen {

/// What finds the light around a record: rays on the CPU or the rasteriser.
enum class GatherRoad { kRays, kRaster };

/// Texels along a hemisphere's side where none are asked for.
int gatherSize(GatherRoad road, float accuracy, HemisphereKind kind = HemisphereKind::kHemicube);
/// Half-extent of a hemisphere's plane where none is asked for.
float gatherExtent(HemisphereKind kind);

/// Milliseconds that a record costs among so many triangles: fixed + factor * triangles^power.
struct RecordCost {
    double fixed = 0, factor = 0, power = 0;
    double milliseconds(int triangles) const;
};

/// What decides between the roads on a machine. Only the ratio of the two matters.
struct RoadCosts {
    RecordCost rays, raster;  ///< at the same accuracy, of gatherSize() texels
    /// How many times as long the raster takes in addition for the rays' error.
    double raster_equal_error = 1;
};

/// Mesa's software rasteriser and two threads: fitted within a factor of 1.7 to what `bench/stages`
/// measured on a quiet machine (diffuse records, default accuracy), the last to `sheen chart`
/// (docs/decisions.md).
constexpr RoadCosts kSoftwareCosts = {
    .rays = {0.07, 0.005, 0.33}, .raster = {0.27, 4e-4, 0.77}, .raster_equal_error = 3.0};

struct RoadChoice {
    GatherRoad road = GatherRoad::kRays;
    double raster_ratio = 1;  ///< how many times as long as rays the raster takes for their error
};

/// The cheaper road in a scene of so many triangles; rays where they are as cheap.
RoadChoice cheaperRoad(const RoadCosts& costs, int triangles);

}  // namespace sheen
