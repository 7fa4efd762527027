// Random places for rays, the same in every run.
#pragma once

#include <bit>
#include <cstdint>

#include "core/math.h"

namespace sheen {

/// The PCG hash [JO20].
inline uint32_t pcgHash(uint32_t x) {
    const uint32_t state = x * 747796405u + 2891336453u;
    const uint32_t word = ((state >> ((state >> 28u) + 4u)) ^ state) * 277803737u;
    return (word >> 22u) ^ word;
}

/// A hash of a point of a triangle, by Embree's barycentric coordinates: what the point says, and
/// no count of points before it.
inline uint32_t hashOfPoint(uint32_t triangle, float u, float v) {
    return pcgHash(triangle +
                   pcgHash(std::bit_cast<uint32_t>(u) + pcgHash(std::bit_cast<uint32_t>(v))));
}

/// A pseudo-random place in [0, 1)^2 for ray `ray` of whatever has index `of`.
inline vec2 randomPlace(uint32_t of, uint32_t ray) {
    const uint32_t bits = pcgHash(ray + pcgHash(of));
    return vec2(static_cast<float>(bits & 0xffffu), static_cast<float>(bits >> 16u)) * 0x1p-16f;
}

/// Points spread evenly over [0, 1)^3, however many are taken: from a random one on, the one of
/// `use` of whatever has index `of`, by multiples of the powers of 1 / x, x^4 = x + 1 [Rob18]. Each
/// by itself is as random as the first; for rays that follow each other they are strata.
class SpreadPlaces {
  public:
    SpreadPlaces(uint32_t of, uint32_t use)
        : start_(randomPlace(of, use), randomPlace(of, ~use).x) {}
    vec3 next() {
        constexpr vec3 kStep(0.8191725f, 0.6710436f, 0.5497005f);
        return glm::fract(start_ + static_cast<float>(taken_++) * kStep);
    }

  private:
    vec3 start_;
    uint32_t taken_ = 0;
};

}  // namespace sheen
