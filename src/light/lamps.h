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
    /// All triangles of the tracer's scene that emit; none where lightmaps hold their light.
    explicit LampSampler(const Tracer& tracer);

    bool empty() const { return tree_.empty(); }
    bool isLamp(uint32_t triangle) const { return entryOf(triangle) != kNone; }

    /// Light on the way from a lamp.
    struct Sample {
        vec3 wi;            ///< unit, toward the lamp
        float distance;     ///< to it
        vec3 radiance;      ///< of its point, nits
        float density;      ///< of the direction, over solid angle: above 0
        Way way;            ///< must be free; not asked where the surface itself is in the way
        bool within_reach;  ///< false: it is seldom seen from so far, as the inside of a bulb, and
                            ///< that it is hidden tells nothing of shadows
    };
    /// Light by three random numbers in [0, 1) that arrives at a surface on the side of the unit
    /// normal n. None where the numbers lead to a lamp that does not shine there.
    std::optional<Sample> sample(const SurfaceSide& surface, const vec3& n, const vec3& u) const;

    /// Whether irradiance() is known: lamps are not too many, and each shines alike all over.
    bool plain() const { return plain_; }
    /// What all lamps would bring to a surface if nothing were in the way, but those that are
    /// seldom seen from so far (Sample::within_reach). [Arv95]
    vec3 irradiance(const SurfaceSide& surface, const vec3& n) const;

    /// Sample::within_reach of the point of a lamp that a ray from there met.
    bool withinReach(const SurfaceSide& surface, const Hit& hit) const;

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
    bool reaches(size_t entry, const Corners& c, const vec3& p) const;
    float farthest(const Tracer& tracer, uint32_t triangle, const vec3& n) const;

    const Scene& scene_;
    std::vector<uint32_t> first_;      // [triangle]: of its two entries in the tree, or kNone
    std::vector<uint32_t> triangles_;  // [entry / 2]; even entries are fronts
    std::vector<float> reaches_;       // [entry]
    std::vector<vec3> emissions_;      // [entry / 2]: mean
    bool plain_ = true;
    LightTree tree_;
};

}  // namespace sheen
