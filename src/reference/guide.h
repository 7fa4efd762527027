// Learns, pixel by pixel, where in the square of sample points the light comes from, and sends more
// samples there: highlights of shiny surfaces seen from a wall fill few of its directions and would
// otherwise decide the noise. It warps sample points and knows nothing of directions or BRDFs, so
// whatever it learned, the estimate stays unbiased.
// Based on: [GBBE18], with a grid in place of their tree.
#pragma once

#include <vector>

#include "core/math.h"

namespace sheen {

/// A sample point, and one over the density at which the guide places points there.
struct GuidedPoint {
    vec2 u{0.0f};
    float weight = 1.0f;
};

/// A density over the unit square, constant on each of size x size cells; size is a power of two.
class Guide {
  public:
    /// Uniform.
    Guide() = default;
    /// `contributions` [row][column] of the cells, each at least 0: what samples there were found
    /// to contribute. The density follows them, blurred over neighbouring cells; three tenths of it
    /// are uniform, so that no weight exceeds 1/0.3 where the samples missed something.
    Guide(int size, const std::vector<float>& contributions);

    /// Maps u in [0, 1)^2, uniform, to a point of this density in [0, 1)^2; strata stay strata.
    GuidedPoint warp(const vec2& u) const;

  private:
    int size_ = 0;
    std::vector<float> columns_;  // [size + 1], cumulative
    std::vector<float> rows_;     // [column][size + 1], cumulative within a column
};

}  // namespace sheen
