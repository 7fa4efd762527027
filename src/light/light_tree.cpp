#include "light/light_tree.h"

#include <algorithm>
#include <cmath>

namespace sheen {
namespace {

// Of what is farther off than it reaches: that it is seen there cannot be excluded.
constexpr float kSeldom = 0.05f;
// Bands that are left out err by less than this.
constexpr float kLeastSent = 0.05f;
constexpr float kMuchLess = 1.0f / 16.0f;

LightBounds united(const LightBounds& a, const LightBounds& b) {
    LightBounds result = a;
    result.box.add(b.box.lower);
    result.box.add(b.box.upper);
    result.intensity.all += b.intensity.all;
    result.intensity.toward += b.intensity.toward;
    result.intensity.around += b.intensity.around;
    result.reach = std::max(a.reach, b.reach);
    return result;
}

float sineOf(float cosine) { return std::sqrt(std::max(1.0f - cosine * cosine, 0.0f)); }

// The cosine of an angle less another, both by their cosine; 1 where that is negative.
float cosOfLess(float cos_a, float cos_b) {
    return cos_a >= cos_b ? 1.0f : cos_a * cos_b + sineOf(cos_a) * sineOf(cos_b);
}

}  // namespace

Intensity Intensity::byCosine(const vec3& n, float power) {
    return {.all = power * (1.0f / 4.0f - 5.0f / 32.0f),
            .toward = power / 2.0f * n,
            .around = power * 15.0f / 32.0f * glm::outerProduct(n, n)};
}

// The integrals of Legendre's polynomials over the cone, times theirs. [RH01]
Intensity Intensity::inCone(const vec3& axis, float c, float power) {
    const float second = power * 1.25f * (c - c * c * c);
    return {.all = power * 0.5f * (1.0f - c) - 0.5f * second,
            .toward = power * 0.75f * (1.0f - c * c) * axis,
            .around = 1.5f * second * glm::outerProduct(axis, axis)};
}

// By the square of the distance and the greatest cosine to n that its bounds allow. 0 only where it
// brings nothing.
float LightTree::Node::importance(const vec3& p, const vec3& n) const {
    const vec3 way = p - center;
    const bool below = glm::dot(n, way) >= glm::dot(glm::abs(n), half);
    if (below || (leaf && glm::dot(intensity.toward, way) < 0.0f)) {
        return 0.0f;
    }
    const float distance2 = glm::dot(way, way);
    if (distance2 <= 1.001f * radius2) {
        return intensity.mean() /
               std::max(radius2, 1e-30f);  // within its bounds: no angle is known
    }
    const float inverse = 1.0f / std::sqrt(distance2);
    const float cos_seen =
        std::sqrt(1.0f - radius2 * inverse * inverse);  // half the angle it fills
    const float cos_received = cosOfLess(-glm::dot(n, way) * inverse, cos_seen);
    if (cos_received <= 0.0f) {
        return 0.0f;
    }
    // The nearer, the less its middle's direction stands for all of it.
    const float least = intensity.mean() * std::max(radius2 * inverse * inverse, kLeastSent);
    const float sent = std::max(intensity.in(way * inverse), least);
    const float seen = distance2 > reach2 ? kSeldom : 1.0f;
    return seen * sent * cos_received * inverse * inverse;
}

LightTree::Node::Node(const LightBounds& b, uint32_t second_, bool leaf_)
    : center(b.box.center()),
      half(0.5f * (b.box.upper - b.box.lower)),
      radius2(glm::dot(half, half)),
      intensity(b.intensity),
      reach2((b.reach + std::sqrt(radius2)) * (b.reach + std::sqrt(radius2))),
      second(second_),
      leaf(leaf_) {}

LightTree::LightTree(std::span<const LightBounds> lights) : trails_(lights.size()) {
    std::vector<uint32_t> order;
    for (uint32_t i = 0; i < lights.size(); ++i) {
        if (lights[i].intensity.mean() > 0.0f) {
            order.push_back(i);
        }
    }
    if (!order.empty()) {
        nodes_.reserve(2 * order.size());
        build(lights, order, 0, 0);
    }
}

// Orders lights so that the first of them, as many as it returns, and the others are better apart:
// lights that reach much less far, such as the inner sides of a bulb, which would be taken for its
// outer ones; then halves by number, across the longest side. A path is at most as long as a trail
// has bits.
size_t LightTree::halve(std::span<const LightBounds> lights, std::span<uint32_t> order) {
    Bounds middles;
    float farthest = 0.0f;
    for (const uint32_t i : order) {
        middles.add(lights[i].box.center());
        farthest = std::max(farthest, lights[i].reach);
    }
    const auto less = std::partition(order.begin(), order.end(), [&](uint32_t i) {
        return lights[i].reach < farthest * kMuchLess;
    });
    if (less != order.begin()) {
        return static_cast<size_t>(less - order.begin());
    }
    const vec3 size = middles.upper - middles.lower;
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    const auto half = order.begin() + static_cast<ptrdiff_t>(order.size() / 2);
    std::nth_element(order.begin(), half, order.end(), [&](uint32_t a, uint32_t b) {
        const float pa = lights[a].box.center()[axis], pb = lights[b].box.center()[axis];
        return pa != pb ? pa < pb : a < b;
    });
    return order.size() / 2;
}

LightBounds LightTree::build(std::span<const LightBounds> lights, std::span<uint32_t> order,
                             uint64_t trail, int depth) {
    const size_t index = nodes_.size();
    if (order.size() == 1) {
        nodes_.emplace_back(lights[order[0]], order[0], true);
        trails_[order[0]] = trail;
        return lights[order[0]];
    }
    nodes_.emplace_back();
    const auto half = order.begin() + static_cast<ptrdiff_t>(halve(lights, order));
    const LightBounds first = build(lights, {order.begin(), half}, trail, depth + 1);
    const auto second = static_cast<uint32_t>(nodes_.size());
    const LightBounds bounds =
        united(first, build(lights, {half, order.end()}, trail | uint64_t{1} << depth, depth + 1));
    nodes_[index] = Node(bounds, second, false);
    return bounds;
}

std::optional<LightTree::Choice> LightTree::choose(const vec3& p, const vec3& n, float u,
                                                   uint32_t node) const {
    if (nodes_.empty()) {
        return std::nullopt;
    }
    float probability = 1.0f;
    uint32_t index = node;
    while (!nodes_[index].leaf) {
        const float first = nodes_[index + 1].importance(p, n);
        const float second = nodes_[nodes_[index].second].importance(p, n);
        if (!(first + second > 0.0f)) {
            return std::nullopt;
        }
        const float share = first / (first + second);
        const bool to_first = u < share;
        u = std::min(to_first ? u / share : (u - share) / (1.0f - share), 0x1.fffffep-1f);
        probability *= to_first ? share : 1.0f - share;
        index = to_first ? index + 1 : nodes_[index].second;
    }
    return Choice{.light = nodes_[index].second, .probability = probability, .u = u};
}

size_t LightTree::cut(const vec3& p, const vec3& n, std::span<uint32_t> nodes) const {
    struct Part {
        float importance;  // 0: cannot be parted
        uint32_t node;
    };
    const auto less = [](const Part& a, const Part& b) { return a.importance < b.importance; };
    std::vector<Part> parts;  // a heap
    const auto add = [&](uint32_t node) {
        const float importance = nodes_[node].importance(p, n);
        if (importance > 0.0f) {
            parts.push_back({nodes_[node].leaf ? 0.0f : importance, node});
            std::push_heap(parts.begin(), parts.end(), less);
        }
    };
    if (!nodes_.empty()) {
        add(0);
    }
    while (!parts.empty() && parts.front().importance > 0.0f && parts.size() < nodes.size()) {
        std::pop_heap(parts.begin(), parts.end(), less);
        const uint32_t node = parts.back().node;
        parts.pop_back();
        add(node + 1);
        add(nodes_[node].second);
    }
    for (size_t i = 0; i < parts.size(); ++i) {
        nodes[i] = parts[i].node;
    }
    return parts.size();
}

float LightTree::probability(const vec3& p, const vec3& n, uint32_t light) const {
    float probability = 1.0f;
    uint32_t index = 0;
    for (uint64_t trail = trails_[light]; !nodes_[index].leaf; trail >>= 1u) {
        const float first = nodes_[index + 1].importance(p, n);
        const float second = nodes_[nodes_[index].second].importance(p, n);
        if (!(first + second > 0.0f)) {
            return 0.0f;
        }
        const float share = first / (first + second);
        const bool to_second = (trail & 1u) != 0;
        probability *= to_second ? 1.0f - share : share;
        index = to_second ? nodes_[index].second : index + 1;
    }
    return nodes_[index].second == light ? probability : 0.0f;
}

}  // namespace sheen
