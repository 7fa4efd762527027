// Translation gradients against finite differences of converged rays, and what they are worth at a
// distance from the record.
#pragma once

#include "accuracy_sites.h"

namespace sheen::bench {

/// Writes gradients*.csv and the tables gradients_*.md.
void studyGradients(const BenchScenes& scenes, int sites, const Output& output);

}  // namespace sheen::bench
