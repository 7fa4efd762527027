// Where records lie, for finding those that are near enough to a new one to matter.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "core/math.h"

namespace sheen {

/// An octree of spheres around points, numbered in the order of insertion. Radii may shrink later:
/// what a node knows of them is a bound.
class RecordTree {
  public:
    /// `bounds` hold all points.
    explicit RecordTree(const Bounds& bounds);

    void insert(const vec3& position, float radius);

    /// Calls visit(index) in any order for all points of which `reaches(distance squared to the
    /// node, greatest radius in it)` may hold; where it does not for a node it must not for what
    /// is in it.
    template <typename Reaches, typename Visit>
    void visit(const vec3& p, const Reaches& reaches, const Visit& visit) const {
        visitNode(0, root_, p, reaches, visit);
    }

  private:
    struct Node {
        float greatest_radius = 0.0f;
        uint32_t first_child = 0;  // 0: a leaf
        std::vector<uint32_t> points = {};
    };
    struct Cube {
        vec3 center{};
        float half = 0.0f;

        int octantOf(const vec3& p) const {
            return (p.x > center.x ? 1 : 0) + (p.y > center.y ? 2 : 0) + (p.z > center.z ? 4 : 0);
        }
        Cube octant(int i) const {
            const float quarter = 0.5f * half;
            return {center + quarter * vec3((i & 1) != 0 ? 1 : -1, (i & 2) != 0 ? 1 : -1,
                                            (i & 4) != 0 ? 1 : -1),
                    quarter};
        }
        // Centres are rounded at each level: by so much may a point lie outside its cube.
        float slack() const {
            const vec3 c = glm::abs(center) + half;
            return 4e-6f * std::max({c.x, c.y, c.z});
        }
        float distance2(const vec3& p) const {
            const vec3 d = glm::max(glm::abs(p - center) - half - slack(), vec3(0.0f));
            return glm::dot(d, d);
        }
    };

    template <typename Reaches, typename Visit>
    void visitNode(uint32_t index, const Cube& cube, const vec3& p, const Reaches& reaches,
                   const Visit& visit) const {
        const Node& node = nodes_[index];
        if (!reaches(cube.distance2(p), node.greatest_radius)) {
            return;
        }
        for (uint32_t point : node.points) {
            visit(point);
        }
        if (node.first_child != 0) {
            // The nearest first: those that narrow a search come early.
            const int nearest = cube.octantOf(p);
            for (int i = 0; i < 8; ++i) {
                const int child = i ^ nearest;
                visitNode(node.first_child + static_cast<uint32_t>(child), cube.octant(child), p,
                          reaches, visit);
            }
        }
    }

    Cube root_;
    std::vector<Node> nodes_;
    std::vector<vec4> spheres_;
};

}  // namespace sheen
