// What is solid: closed surfaces that face outward. A point within one is seen by no one.
#pragma once

#include <vector>

#include "rays/surface_point.h"
#include "rays/tracer.h"

namespace sheen {

class Solids {
  public:
    /// Of the tracer's scene; without those that lights or cameras stand in: those are rooms.
    explicit Solids(const Tracer& tracer);

    bool empty() const { return count_ == 0; }
    /// Whether most rays that leave a point of a surface meet solids from within.
    bool bury(const SurfaceSide& p, const vec3& normal) const;

  private:
    std::vector<bool> metFromWithin(const vec3& from) const;

    const Tracer& tracer_;
    std::vector<uint32_t> part_of_;  // [triangle]: connected surfaces
    std::vector<bool> solid_;        // [part]
    int count_ = 0;
};

}  // namespace sheen
