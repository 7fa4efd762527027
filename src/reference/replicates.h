// Mean and variance of the mean of independent, equally good estimates.
#pragma once

#include "core/math.h"

namespace sheen {

struct Replicates {
    int count = 0;
    dvec3 mean{0.0};
    dvec3 squares{0.0};  ///< sum of squared deviations from the mean [Wel62]

    void add(const dvec3& value) {
        ++count;
        const dvec3 delta = value - mean;
        mean += delta / static_cast<double>(count);
        squares += delta * (value - mean);
    }
    vec3 varianceOfMean() const {
        return vec3(squares / (static_cast<double>(count) * (count - 1)));
    }
};

}  // namespace sheen
