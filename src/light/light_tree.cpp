#include "light/light_tree.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace sheen {
namespace {

// The least cone around two.
void widen(LightBounds& a, const LightBounds& b) {
    const LightBounds& wide = a.spread >= b.spread ? a : b;
    const LightBounds& narrow = a.spread >= b.spread ? b : a;
    const float between = std::acos(glm::clamp(glm::dot(wide.axis, narrow.axis), -1.0f, 1.0f));
    if (between + narrow.spread <= wide.spread) {
        a.axis = wide.axis;
        a.spread = wide.spread;
        return;
    }
    const float spread = 0.5f * (wide.spread + between + narrow.spread);
    const vec3 across = narrow.axis - glm::dot(narrow.axis, wide.axis) * wide.axis;
    const float length = glm::length(across);
    if (spread >= kPi || length < 1e-6f) {
        a.spread = kPi;
        return;
    }
    const float turn = spread - wide.spread;
    a.axis = glm::normalize(std::cos(turn) * wide.axis + std::sin(turn) * across / length);
    a.spread = spread;
}

LightBounds united(const LightBounds& a, const LightBounds& b) {
    LightBounds result = a;
    result.box.add(b.box.lower);
    result.box.add(b.box.upper);
    result.power += b.power;
    widen(result, b);
    return result;
}

// The cosine of an angle less another, both by their cosine and sine; 1 where that is negative.
float cosOfLess(float cos_a, float sin_a, float cos_b, float sin_b) {
    return cos_a > cos_b ? 1.0f : cos_a * cos_b + sin_a * sin_b;
}

float sineOf(float cosine) { return std::sqrt(std::max(1.0f - cosine * cosine, 0.0f)); }

// What a node may bring to a point: its power by the square of the distance and by the greatest
// cosines that its bounds allow. 0 only where it brings nothing. [EK18, eq. 3]
float importance(const LightBounds& b, const vec3& p, const vec3& n) {
    const vec3 center = 0.5f * (b.box.lower + b.box.upper);
    const float radius = 0.5f * glm::length(b.box.upper - b.box.lower);
    const vec3 way = p - center;
    const float distance2 = glm::dot(way, way);
    const float least2 = std::max(distance2, radius * radius);
    if (distance2 <= 1.001f * radius * radius) {
        return b.power / std::max(least2, 1e-30f);  // within its bounds: no angle is known
    }
    const vec3 from = way / std::sqrt(distance2);
    const float sin_seen = radius / std::sqrt(distance2);  // of half of the angle it fills
    const float cos_seen = sineOf(sin_seen);
    const float cos_i = glm::dot(n, -from);
    const float cos_received = cosOfLess(cos_i, sineOf(cos_i), cos_seen, sin_seen);
    if (cos_received <= 0.0f) {
        return 0.0f;
    }
    const float angle = std::acos(glm::clamp(glm::dot(b.axis, from), -1.0f, 1.0f));
    const float off = std::max(angle - b.spread - std::asin(std::min(sin_seen, 1.0f)), 0.0f);
    const float cos_sent = std::cos(off);
    return cos_sent > 0.0f ? b.power * cos_received * cos_sent / least2 : 0.0f;
}

}  // namespace

LightTree::LightTree(std::span<const LightBounds> lights) : trails_(lights.size()) {
    std::vector<uint32_t> order;
    for (uint32_t i = 0; i < lights.size(); ++i) {
        if (lights[i].power > 0.0f) {
            order.push_back(i);
        }
    }
    if (!order.empty()) {
        nodes_.reserve(2 * order.size());
        build(lights, order, 0, 0);
    }
}

// Halves by number, across the longest side: a path is then at most as long as a trail has bits.
uint32_t LightTree::build(std::span<const LightBounds> lights, std::span<uint32_t> order,
                          uint64_t trail, int depth) {
    const auto index = static_cast<uint32_t>(nodes_.size());
    nodes_.emplace_back();
    if (order.size() == 1) {
        nodes_[index] = {.bounds = lights[order[0]], .second = order[0], .leaf = true};
        trails_[order[0]] = trail;
        return index;
    }
    Bounds middles;
    const auto middle = [&](uint32_t i) {
        return 0.5f * (lights[i].box.lower + lights[i].box.upper);
    };
    for (const uint32_t i : order) {
        middles.add(middle(i));
    }
    const vec3 size = middles.upper - middles.lower;
    const int axis = size.x >= size.y && size.x >= size.z ? 0 : size.y >= size.z ? 1 : 2;
    const auto half = order.begin() + static_cast<ptrdiff_t>(order.size() / 2);
    std::nth_element(order.begin(), half, order.end(), [&](uint32_t a, uint32_t b) {
        const float pa = middle(a)[axis], pb = middle(b)[axis];
        return pa != pb ? pa < pb : a < b;
    });
    const uint32_t first = build(lights, {order.begin(), half}, trail, depth + 1);
    const uint32_t second =
        build(lights, {half, order.end()}, trail | uint64_t{1} << depth, depth + 1);
    nodes_[index] = {.bounds = united(nodes_[first].bounds, nodes_[second].bounds),
                     .second = second};
    return index;
}

std::optional<LightTree::Choice> LightTree::choose(const vec3& p, const vec3& n, float u) const {
    if (nodes_.empty()) {
        return std::nullopt;
    }
    float probability = 1.0f;
    uint32_t index = 0;
    while (!nodes_[index].leaf) {
        const float first = importance(nodes_[index + 1].bounds, p, n);
        const float second = importance(nodes_[nodes_[index].second].bounds, p, n);
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

float LightTree::probability(const vec3& p, const vec3& n, uint32_t light) const {
    float probability = 1.0f;
    uint32_t index = 0;
    for (uint64_t trail = trails_[light]; !nodes_[index].leaf; trail >>= 1u) {
        const float first = importance(nodes_[index + 1].bounds, p, n);
        const float second = importance(nodes_[nodes_[index].second].bounds, p, n);
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
