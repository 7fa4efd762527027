// Lamps: triangles that emit, sampled as lights. Their first light is direct light of what they
// shine on: rays that gather light from the surroundings see them black.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "light/light_tree.h"
#include "rays/surface_point.h"
#include "rays/tracer.h"

namespace sheen {

/// Safe to use from many threads. The scene must outlive them.
class LampSampler {
  public:
    /// All triangles of the tracer's scene that emit; none where they are not `wanted`.
    explicit LampSampler(const Tracer& tracer, bool wanted = true);

    bool empty() const { return tree_.empty(); }
    bool isLamp(uint32_t triangle) const { return entryOf(triangle) != kNone; }

    /// Light on the way from a lamp.
    struct Sample {
        vec3 wi;            ///< unit, toward the lamp
        float distance;     ///< to it
        vec3 radiance;      ///< of its point, nits
        float density;      ///< of the direction, over solid angle: above 0
        Way way;            ///< must be free
        bool within_reach;  ///< false: it is seldom seen from so far, as the inside of a bulb, and
                            ///< that it is hidden tells nothing of shadows
    };
    /// Light by three random numbers in [0, 1) that arrives at a surface from where it is not known
    /// to be dark: on the sides of its geometric normal and of the unit normal n. None where the
    /// numbers lead to a lamp that does not shine there.
    std::optional<Sample> sample(const SurfaceSide& surface, const vec3& n, const vec3& u) const;

    /// The density with which sample() finds the point of a lamp that a ray from there met.
    float density(const SurfaceSide& surface, const vec3& n, const Hit& hit,
                  const vec3& direction) const;

    /// What the point of a lamp that was met emits, nits.
    vec3 radiance(const Hit& hit) const;

  private:
    static constexpr uint32_t kNone = ~0u;
    struct Corners;
    uint32_t entryOf(uint32_t triangle) const { return first_.empty() ? kNone : first_[triangle]; }
    Corners corners(uint32_t triangle) const;
    float farthest(const Tracer& tracer, uint32_t triangle, const vec3& n) const;

    const Scene& scene_;
    std::vector<uint32_t> first_;      // [triangle]: of its two entries in the tree, or kNone
    std::vector<uint32_t> triangles_;  // [entry / 2]; even entries are fronts
    std::vector<float> reaches_;       // [entry]
    LightTree tree_;
};

}  // namespace sheen
