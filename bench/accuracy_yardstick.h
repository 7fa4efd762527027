// What the program's gather costs beside a plain one by Embree of the same error.
#pragma once

#include "accuracy_sites.h"

namespace sheen::bench {

/// Irradiance errors and times of the program's gather and of the octree baseline's, which is
/// stratified rays by the cosine and shadow rays; measured batch by batch in turns: yardstick.csv
/// and .md.
void studyYardstick(const BenchScenes& scenes, int sites, const Output& output);

}  // namespace sheen::bench
