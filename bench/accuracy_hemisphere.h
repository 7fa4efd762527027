// What a record's hemisphere misses: irradiance and glossy light from its texels against converged
// rays.
#pragma once

#include "accuracy_sites.h"

namespace sheen::bench {

/// Table 8.1 of [GKB09], with the ways of the program beside: writes hemispheres.csv and .md.
void studyHemispheres(const BenchScenes& scenes, int sites, const Output& output);
/// The same over extents, sizes and rays a texel: hemisphere_sizes.csv and .md.
void studyHemisphereSizes(const BenchScenes& scenes, int sites, const Output& output);

}  // namespace sheen::bench
