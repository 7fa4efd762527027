// What coefficients say of a direction.
#pragma once

#include <vector>

#include "sh/sh.h"

namespace sheen {

inline double evaluate(const std::vector<float>& c, const vec3& d, int order) {
    const shared::ShVector y = shared::shBasis(d, order);
    double sum = 0.0;
    for (int k = 0; k < order * order; ++k) {
        sum += static_cast<double>(c[static_cast<size_t>(k)]) * y.c[k];
    }
    return sum;
}

}  // namespace sheen
