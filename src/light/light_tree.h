// A choice among many lights by what each brings to a point, nearly, made on the way down a tree.
// Based on: [EK18], with what nodes send by spherical harmonics instead of cones of normals.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/math.h"

namespace sheen {

/// What lights send in a unit direction w: all + toward . w + w . around w, relative to each other.
/// Sums of lights are sums of these.
struct Intensity {
    float all = 0.0f;
    vec3 toward{0.0f};
    mat3 around{0.0f};

    /// Of a light that shines alike everywhere.
    static Intensity everywhere(float power) { return {.all = power}; }
    /// Of a surface, by the cosine to its unit normal, none behind it: three bands. [RH01, eq. 8]
    static Intensity byCosine(const vec3& n, float power);
    /// Of a light that shines alike within an angle of that cosine around a unit axis, not outside:
    /// likewise.
    static Intensity inCone(const vec3& axis, float cosine, float power);

    /// Over all directions.
    float mean() const { return all + (around[0][0] + around[1][1] + around[2][2]) / 3.0f; }
    float in(const vec3& w) const { return all + glm::dot(toward, w) + glm::dot(w, around * w); }
};

/// Where a light lies, and what it sends.
struct LightBounds {
    Bounds box;
    Intensity intensity;
    float reach = kInfinity;  ///< farther off it is seldom seen
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
    /// normal n. None where the number leads to lights that cannot reach that side. `node`: one of
    /// cut()'s, whose lights alone are chosen from.
    std::optional<Choice> choose(const vec3& p, const vec3& n, float u, uint32_t node = 0) const;

    /// Nodes, as many as fit into `nodes` at the most, that hold all lights which can reach that
    /// side: what counts most is parted first. Returns how many.
    size_t cut(const vec3& p, const vec3& n, std::span<uint32_t> nodes) const;

    /// How probable it is that choose() chooses this light.
    float probability(const vec3& p, const vec3& n, uint32_t light) const;

  private:
    struct Node {
        vec3 center{0.0f};
        vec3 half{0.0f};       // of its box's sides
        float radius2 = 0.0f;  // of the sphere around that, squared
        Intensity intensity;
        float reach2 = kInfinity;  // from the center, squared
        uint32_t second = 0;       // child; the first one follows. Of a leaf the light
        bool leaf = false;

        Node() = default;
        Node(const LightBounds& bounds, uint32_t second, bool leaf);
        float importance(const vec3& p, const vec3& n) const;
    };
    static size_t halve(std::span<const LightBounds> lights, std::span<uint32_t> order);
    // Returns the bounds of the node that it adds.
    LightBounds build(std::span<const LightBounds> lights, std::span<uint32_t> order,
                      uint64_t trail, int depth);

    std::vector<Node> nodes_;
    std::vector<uint64_t> trails_;  // [light]: bit d: which child at depth d leads to it
};

}  // namespace sheen
