#include "baselines/ward_octree.h"

#include <algorithm>
#include <cmath>

namespace sheen {
namespace {

// A record serves nothing that lies farther off its tangent plane, in either direction, than this
// share of its radius.
constexpr float kSlab = 0.03f;
// Weight of the angle between normals: 1 in [WRC88, eq. 10]. Measured on curved surfaces.
constexpr float kTilt = 4.0f;
constexpr int kDeepest = 40;

// Whether records of a node may serve p.
auto reaching(const vec3& p) {
    return [p](const vec3& center, float half) {
        const vec3 d = glm::abs(p - center);
        return std::max({d.x, d.y, d.z}) <= 2.0f * half;
    };
}

}  // namespace

float wardError(const WardRecord& record, const vec3& p, const vec3& n) {
    const vec3 d = p - record.position;
    if (std::abs(glm::dot(d, n + record.normal)) > 2.0f * kSlab * record.radius) {
        return kInfinity;
    }
    const float tilt = std::max(0.0f, 1.0f - glm::dot(n, record.normal));
    return glm::length(d) / record.radius + std::sqrt(kTilt * tilt);
}

WardOctree::WardOctree(const Bounds& bounds, float accuracy) : accuracy_(accuracy) {
    // About the origin, its side a power of two: near there all cubes' corners are floats.
    Node root;
    const float farthest = std::max(maxAbs(bounds.lower), maxAbs(bounds.upper));
    root.half = bounds.empty() ? 0.0f : std::exp2(std::ceil(std::log2(farthest)));
    nodes_.push_back(root);
}

template <class Reach, class Visit>
bool WardOctree::anyOf(const Reach& reach, const Visit& visit) const {
    // Depth first; a node's siblings wait.
    int stack[7 * kDeepest + 8];
    int size = 0;
    stack[size++] = 0;
    while (size > 0) {
        const Node& node = nodes_[static_cast<size_t>(stack[--size])];
        for (const int record : node.records) {
            if (visit(record)) {
                return true;
            }
        }
        for (const int child : node.children) {
            if (child >= 0 && reach(nodes_[static_cast<size_t>(child)].center,
                                    nodes_[static_cast<size_t>(child)].half)) {
                stack[size++] = child;
            }
        }
    }
    return false;
}

int WardOctree::nodeFor(const vec3& p, float reach) {
    int node = 0;
    for (int depth = 0; depth < kDeepest && nodes_[static_cast<size_t>(node)].half >= 2.0f * reach;
         ++depth) {
        const vec3 center = nodes_[static_cast<size_t>(node)].center;
        const float half = 0.5f * nodes_[static_cast<size_t>(node)].half;
        const size_t octant =
            (p.x >= center.x ? 1u : 0u) + (p.y >= center.y ? 2u : 0u) + (p.z >= center.z ? 4u : 0u);
        int child = nodes_[static_cast<size_t>(node)].children[octant];
        if (child < 0) {
            child = static_cast<int>(nodes_.size());
            Node added;
            added.half = half;
            added.center = center + half * (2.0f * vec3(glm::greaterThanEqual(p, center)) - 1.0f);
            nodes_.push_back(added);
            nodes_[static_cast<size_t>(node)].children[octant] = child;
        }
        node = child;
    }
    return node;
}

void WardOctree::clampNeighbours(int added) {
    WardRecord& record = records_[static_cast<size_t>(added)];
    float radius = record.radius;
    // A node's records were given at most this many half sides of radius.
    const float per_half = 1.0f / accuracy_;
    const auto near = [&](const vec3& center, float half) {
        const vec3 d = glm::max(glm::abs(record.position - center) - half, vec3(0.0f));
        const float reach = std::max(radius, half * per_half);
        return glm::dot(d, d) <= reach * reach;
    };
    anyOf(near, [&](int i) {
        const WardRecord& other = records_[static_cast<size_t>(i)];
        radius = std::min(radius, other.radius + glm::length(other.position - record.position));
        return false;
    });
    record.radius = std::max(radius, least_radius_[static_cast<size_t>(added)]);
    radius = record.radius;
    anyOf(near, [&](int i) {
        WardRecord& other = records_[static_cast<size_t>(i)];
        const float limit = radius + glm::length(other.position - record.position);
        other.radius =
            std::min(other.radius, std::max(limit, least_radius_[static_cast<size_t>(i)]));
        return false;
    });
}

void WardOctree::insert(const WardRecord& record, float least_radius) {
    const int index = static_cast<int>(records_.size());
    records_.push_back(record);
    least_radius_.push_back(least_radius);
    clampNeighbours(index);
    const int node = nodeFor(record.position, accuracy_ * records_.back().radius);
    nodes_[static_cast<size_t>(node)].records.push_back(index);
}

Interpolated WardOctree::lookup(const vec3& p, const vec3& n, float accuracy) const {
    Interpolated result;
    anyOf(reaching(p), [&](int i) {
        const WardRecord& record = records_[static_cast<size_t>(i)];
        const float error = wardError(record, p, n);
        if (error < accuracy) {
            const float weight = 1.0f - error / accuracy;
            result.irradiance += weight * record.extrapolate(p, n);
            result.weight += weight;
            ++result.records;
        }
        return false;
    });
    if (result.weight > 0.0f) {
        result.irradiance /= result.weight;
    }
    return result;
}

bool WardOctree::serves(const vec3& p, const vec3& n, float accuracy) const {
    return anyOf(reaching(p), [&](int i) {
        return wardError(records_[static_cast<size_t>(i)], p, n) < accuracy;
    });
}

}  // namespace sheen
