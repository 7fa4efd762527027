// The vector types of the project and the few helpers GLM has no name for.
#pragma once

#include <cmath>
#include <cstddef>
#include <glm/glm.hpp>
#include <limits>

namespace sheen {

using glm::dvec3;
using glm::ivec2;
using glm::ivec3;
using glm::mat3;
using glm::mat4;
using glm::uvec2;
using glm::uvec3;
using glm::uvec4;
using glm::vec2;
using glm::vec3;
using glm::vec4;

constexpr float kPi = 3.14159265358979323846f;
constexpr float kInfinity = std::numeric_limits<float>::infinity();

/// Of a linear Rec. 709 colour.
constexpr vec3 kLuminanceWeights(0.2126f, 0.7152f, 0.0722f);
inline float luminance(const vec3& c) { return glm::dot(kLuminanceWeights, c); }

/// Of two arrays of n, in several partial sums, since the compiler may not reorder one.
inline float dotProduct(const float* a, const float* b, size_t n) {
    constexpr size_t kLanes = 16;
    float lanes[kLanes] = {};
    size_t i = 0;
    for (; i + kLanes <= n; i += kLanes) {
        for (size_t k = 0; k < kLanes; ++k) {
            lanes[k] += a[i + k] * b[i + k];
        }
    }
    float sum = 0.0f;
    for (float lane : lanes) {
        sum += lane;
    }
    for (; i < n; ++i) {
        sum += a[i] * b[i];
    }
    return sum;
}

inline bool finite(const vec3& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

inline float maxAbs(const vec3& p) {
    return glm::max(std::abs(p.x), glm::max(std::abs(p.y), std::abs(p.z)));
}

/// What is left of light of which that share passes, channel by channel, where one number says it:
/// the middle of the channels.
inline float passingShare(const vec3& passes) {
    return 0.5f * (glm::min(passes.x, glm::min(passes.y, passes.z)) + maxAbs(passes));
}

/// The luminance of what passes; of a grey share, exactly that share of the light's.
inline float luminancePassing(const vec3& passes, const vec3& light) {
    const float most = maxAbs(passes);
    return most > 0.0f ? most * luminance(passes / most * light) : 0.0f;
}

/// Axis-aligned bounds, world space; empty (lower > upper) until a point is added.
struct Bounds {
    vec3 lower{kInfinity};
    vec3 upper{-kInfinity};

    bool empty() const { return lower.x > upper.x; }
    void add(const vec3& p) {
        lower = glm::min(lower, p);
        upper = glm::max(upper, p);
    }
    vec3 center() const { return 0.5f * (lower + upper); }
    /// Length of the diagonal: the "scene's size"; 0 when empty.
    float size() const { return empty() ? 0.0f : glm::length(upper - lower); }
    bool operator==(const Bounds&) const = default;
};

}  // namespace sheen
