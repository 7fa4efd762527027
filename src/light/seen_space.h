// Where light is wanted, coarsely.
#pragma once

#include <cstdint>
#include <vector>

#include "scene/scene.h"

namespace sheen {

/// The space around points whose light is wanted, in cells.
class SeenSpace {
  public:
    SeenSpace() = default;
    /// That of points and of what lies within a cell of them.
    explicit SeenSpace(const std::vector<vec3>& points);

    bool empty() const { return filled_.empty(); }
    /// Of a cell: nothing farther off counts for a point.
    float reach() const { return size_; }
    bool contains(const vec3& p) const;

  private:
    static constexpr int kCells = 16;  // along the longest side

    ivec3 cellOf(const vec3& p) const;

    vec3 lower_{0.0f};
    float size_ = 0.0f;
    ivec3 counts_{0};
    std::vector<uint8_t> filled_;  // [z][y][x]
};

}  // namespace sheen
