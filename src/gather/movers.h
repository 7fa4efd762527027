// Surfaces that move about a frame, and what of a record's hemisphere they may hide.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "gather/site.h"
#include "hemisphere/hemisphere.h"
#include "rays/tracer.h"

namespace sheen {

/// Safe to use from many threads.
class Movers {
  public:
    Movers() = default;
    /// `moves`: [triangle], 1 of those that do; empty: none does. `before`: where the vertices were
    /// in the frame before, which counts as well: what something has left is seen anew; empty:
    /// where they are.
    Movers(const Scene& scene, std::vector<uint8_t> moves, std::span<const vec3> before = {});

    bool any() const { return tracer_ != nullptr; }
    bool moves(uint32_t triangle) const { return triangle < moves_.size() && moves_[triangle]; }

    /// The texels of the hemisphere over `normal` at a point through which something that moves may
    /// be seen: all of these, and some others.
    std::vector<uint32_t> texelsToward(const Hemisphere& h, const vec3& eye,
                                       const vec3& normal) const;
    /// Whether each ray meets something that moves nearer than so far, where there is any.
    std::vector<uint8_t> hide(const vec3& eye, std::span<const vec3> directions,
                              std::span<const float> distances) const;

  private:
    // A ball around some of the triangles.
    struct Ball {
        vec3 center{0.0f};
        float radius = 0.0f;
    };
    std::vector<uint8_t> moves_;
    std::unique_ptr<Scene> scene_;  // of the triangles that move alone, now and before
    std::unique_ptr<Tracer> tracer_;
    std::vector<Ball> balls_;
};

}  // namespace sheen
