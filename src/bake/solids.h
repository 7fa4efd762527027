// What is solid: closed surfaces that face outward, and those whose material shows from the front
// alone. A point from where their backs are seen is one that no one sees. So is one from where
// nothing is seen but the back of one connected surface, as under a box without a bottom.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "rays/surface_point.h"
#include "rays/tracer.h"

namespace sheen {

class Solids {
  public:
    /// Of the tracer's scene. Connected surfaces that lights or cameras stand in are rooms, and
    /// bury nothing.
    explicit Solids(const Tracer& tracer);

    /// Whether most rays that leave a point of a surface meet backs of solids, or all of them that
    /// of one surface.
    bool bury(const SurfaceSide& p, const vec3& normal) const;

    /// Likewise of rays that leave a point in the air.
    bool hold(const vec3& p) const;

  private:
    std::vector<bool> closedParts(const std::vector<uint32_t>& places) const;
    bool enclose(std::span<const Hit> hits) const;
    std::optional<uint32_t> metFromWithin(const vec3& from) const;

    const Tracer& tracer_;
    std::vector<uint32_t> part_of_;  // [triangle]: connected surfaces
    uint32_t parts_ = 0;
    std::vector<bool> room_;   // [part]
    std::vector<bool> solid_;  // [triangle]
};

}  // namespace sheen
