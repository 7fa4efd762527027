// Points in space, found by where they lie: those of a lightmap's texels, which form no image that
// a record's region could be projected to.
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "core/math.h"

namespace sheen {

/// A kd-tree. Safe to read from many threads.
class PointIndex {
  public:
    /// Of the points whose numbers are given, each below the number of `points`.
    PointIndex(const std::vector<vec3>& points, std::vector<uint32_t> numbers);
    ~PointIndex();
    PointIndex(const PointIndex&) = delete;
    PointIndex& operator=(const PointIndex&) = delete;

    /// Numbers of the points nearer to p than `radius`, in any order, the same each time.
    std::vector<uint32_t> within(const vec3& p, float radius) const;

  private:
    struct Tree;
    std::unique_ptr<Tree> tree_;
};

}  // namespace sheen
