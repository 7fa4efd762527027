// What the records say of the image's error: each one is predicted by its neighbours.
#pragma once

#include <span>

#include "receivers/receivers.h"
#include "record/record.h"

namespace sheen {

/// How wrong an indirect image is by leave-one-out predictions.
struct NeighbourErrors {
    /// Of the whole image (docs/metrics.md). 0 without records; infinite where none of them serves
    /// another's pixel: then nothing is known.
    double rel_rmse = 0;
    /// Of the pixels of every second row and column: the squared error of their luminance that is
    /// expected; 0 of the others, and where nothing is known.
    Image<float> squares;
};

/// Whether a pixel is among those whose errors are expected: as many as are needed.
inline bool isJudged(size_t pixel, int width) {
    const auto w = static_cast<size_t>(width);
    return ((pixel % w | pixel / w) & 1) == 0;
}

/// At each record's own pixel: what the records around it say without it, against what it found
/// itself, as a share of the light there; where few records reach, the less known, the more the
/// median record's. At a pixel such errors add up as independent ones, by the records' weights.
/// What all records get wrong alike is not seen: see probes.h. `record_pixels`: that they lie at.
NeighbourErrors neighbourErrors(const Receivers& receivers, const RecordCache& cache,
                                std::span<const int> record_pixels, const WeightParams& weight,
                                const Image<vec3>& indirect);

}  // namespace sheen
