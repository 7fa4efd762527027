// What the records say of the image's error: each one is predicted by its neighbours.
#pragma once

#include "cache/placement.h"

namespace sheen {

/// Estimate of the rel_rmse of an indirect image (docs/metrics.md) from leave-one-out predictions:
/// at each record's own pixel, what the records around it say without it, against what it found
/// itself, as a share of the light there; where few records reach, the less known, the more the
/// median record's. At a pixel such errors add up as independent ones, by the records' weights.
/// What all records get wrong alike is not seen. 0 without records;
/// infinity where none of them serves another's pixel: then nothing is known.
double estimateRelRmse(const GBuffer& gbuffer, const PixelClasses& classes, const PixelLobes& lobes,
                       const Placement& placement, const WeightParams& weight,
                       const Image<vec3>& indirect);

}  // namespace sheen
