// The chapter's comparison of hemispheres, by the rasteriser.
#pragma once

#include "accuracy_sites.h"

namespace sheen::bench {

/// Table 8.1 of [GKB09] by the program's raster gather, beside the published figures: writes
/// raster.csv and .md.
void studyRaster(const BenchScenes& scenes, int sites, const Output& output);

}  // namespace sheen::bench
