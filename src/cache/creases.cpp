#include "cache/creases.h"

#include <algorithm>

#include "core/parallel.h"

namespace sheen {
namespace {

constexpr int kWindow = 2;
// Of about the same normal.
constexpr float kParallel = 0.9f;
// In front of the tangent plane, by this much of the way there: more than surfaces curve.
constexpr float kSteepness = 0.3f;
// Higher steps are known to the records around them; in footprints.
constexpr float kFarthest = 4.0f;

}  // namespace

Image<uint8_t> findCreases(const GBuffer& gbuffer) {
    Image<uint8_t> creases(gbuffer.width, gbuffer.height);
    const auto stands_before = [&](const vec4& position, const vec3& normal, int x, int y) {
        const vec4& other = gbuffer.position.at(x, y);
        const vec3 way = vec3(other) - vec3(position);
        const float height = glm::dot(way, normal);
        const float farthest = kFarthest * position.w * gbuffer.pixel_angle;
        const float length2 = glm::dot(way, way);
        return height > 0.0f && height * height > kSteepness * kSteepness * length2 &&
               length2 < farthest * farthest && other.w > 0.0f &&
               glm::dot(vec3(gbuffer.normal.at(x, y)), normal) > kParallel;
    };
    parallelFor(gbuffer.height, [&](int y) {
        for (int x = 0; x < gbuffer.width; ++x) {
            const vec4& position = gbuffer.position.at(x, y);
            const vec3 normal(gbuffer.normal.at(x, y));
            bool crease = false;
            for (int v = std::max(y - kWindow, 0);
                 v <= std::min(y + kWindow, gbuffer.height - 1) && position.w > 0.0f; ++v) {
                for (int u = std::max(x - kWindow, 0);
                     u <= std::min(x + kWindow, gbuffer.width - 1); ++u) {
                    crease = crease || stands_before(position, normal, u, v);
                }
            }
            creases.at(x, y) = crease ? 1 : 0;
        }
    });
    return creases;
}

}  // namespace sheen
