// A choice among many lights by what each may bring to a point, made on the way down a tree of
// their bounds. Based on: [EK18].
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/math.h"

namespace sheen {

/// Where a light lies and where it shines to: into the half spaces of normals that deviate from
/// `axis` by at most an angle.
struct LightBounds {
    Bounds box;
    vec3 axis{0.0f, 0.0f, 1.0f};  ///< unit
    float spread = 0.0f;          ///< that angle, radians; pi: it shines everywhere
    float power = 0.0f;           ///< relative; a light of 0 is never chosen
};

class LightTree {
  public:
    LightTree() = default;
    explicit LightTree(std::span<const LightBounds> lights);

    bool empty() const { return nodes_.empty(); }

    struct Choice {
        uint32_t light;
        float probability;
        float u;  ///< a random number as good as the one that it was chosen by
    };
    /// By a random number in [0, 1), for a point p whose light counts on the side of the unit
    /// normal n. None where no light can reach that side.
    std::optional<Choice> choose(const vec3& p, const vec3& n, float u) const;

    /// How probable it is that choose() chooses this light.
    float probability(const vec3& p, const vec3& n, uint32_t light) const;

  private:
    struct Node {
        LightBounds bounds;
        uint32_t second = 0;  // child; the first one follows. A leaf: the light
        bool leaf = false;
    };
    uint32_t build(std::span<const LightBounds> lights, std::span<uint32_t> order, uint64_t trail,
                   int depth);

    std::vector<Node> nodes_;
    std::vector<uint64_t> trails_;  // [light]: bit d: which child at depth d leads to it
};

}  // namespace sheen
