// Triangles laid flat side by side, none over another.
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <map>
#include <unordered_map>
#include <vector>

#include "core/math.h"

namespace sheen {

using Corners = std::array<glm::dvec2, 3>;

/// The rectangle around a triangle.
struct FlatBox {
    glm::dvec2 lower, upper;

    explicit FlatBox(const Corners& c)
        : lower(glm::min(glm::min(c[0], c[1]), c[2])),
          upper(glm::max(glm::max(c[0], c[1]), c[2])) {}
    double side() const { return std::max(upper.x - lower.x, upper.y - lower.y); }
    FlatBox with(const FlatBox& other) const {
        FlatBox both = *this;
        both.lower = glm::min(lower, other.lower);
        both.upper = glm::max(upper, other.upper);
        return both;
    }
    bool meets(const FlatBox& other) const {
        return lower.x < other.upper.x && other.lower.x < upper.x && lower.y < other.upper.y &&
               other.lower.y < upper.y;
    }
};

/// Triangles found by where they lie. Each is kept in a grid whose cells are as large as itself,
/// within a factor of two, so that it lies in four of them at the most: however sizes differ, none
/// fills many cells, and no cell holds many of much less than its size.
class Flat {
  public:
    /// Whether a triangle lies over none of those there, up to rounding.
    bool free(const Corners& c) const;
    void add(const Corners& c);

  private:
    struct Grid {
        std::vector<uint32_t> all;
        std::unordered_map<int64_t, std::vector<uint32_t>> cells;
    };
    struct Cells;
    bool free(const Corners& c, const std::vector<uint32_t>& others) const;
    bool free(const Corners& c, const Cells& cells, const Grid& grid) const;

    std::vector<Corners> placed_;
    std::map<int, Grid> grids_;  // by the cells' size: a power of two
};

}  // namespace sheen
