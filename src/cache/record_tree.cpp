#include "cache/record_tree.h"

#include <algorithm>
#include <cmath>

namespace sheen {
namespace {

constexpr size_t kLeafPoints = 16;
constexpr int kDeepest = 40;  // more than kLeafPoints may lie in one place

}  // namespace

// A cube about the origin, its side a power of two: the cubes within it, down to those of points
// near the origin, have their corners at floats.
RecordTree::RecordTree(const Bounds& bounds) : nodes_(1) {
    const float farthest = std::max(maxAbs(bounds.lower), maxAbs(bounds.upper));
    root_.half = bounds.empty() ? 0.0f : std::exp2(std::ceil(std::log2(farthest)));
}

void RecordTree::insert(const vec3& position, float radius) {
    const auto point = static_cast<uint32_t>(spheres_.size());
    spheres_.emplace_back(position, radius);
    Cube cube = root_;
    uint32_t index = 0;
    for (int depth = 0;; ++depth) {
        nodes_[index].greatest_radius = std::max(nodes_[index].greatest_radius, radius);
        if (nodes_[index].first_child == 0) {
            nodes_[index].points.push_back(point);
            if (nodes_[index].points.size() <= kLeafPoints || depth == kDeepest) {
                return;
            }
            // A full leaf: its points go to its children, each with its own radius.
            const std::vector<uint32_t> points = std::move(nodes_[index].points);
            nodes_[index].points.clear();
            const auto first_child = static_cast<uint32_t>(nodes_.size());
            nodes_[index].first_child = first_child;
            nodes_.resize(nodes_.size() + 8);
            for (uint32_t p : points) {
                const vec4& sphere = spheres_[p];
                Node& child =
                    nodes_[first_child + static_cast<uint32_t>(cube.octantOf(vec3(sphere)))];
                child.greatest_radius = std::max(child.greatest_radius, sphere.w);
                child.points.push_back(p);
            }
            return;
        }
        const int octant = cube.octantOf(position);
        index = nodes_[index].first_child + static_cast<uint32_t>(octant);
        cube = cube.octant(octant);
    }
}

}  // namespace sheen
