#include "receivers/creases.h"

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
constexpr float kHighest = 4.0f;

}  // namespace

std::vector<uint8_t> findCreases(const Receivers& receivers) {
    std::vector<uint8_t> creases(receivers.positions.size());
    const PixelGrid& image = receivers.image;
    const auto stands_before = [&](size_t other, size_t own) {
        const vec3& normal = receivers.normals[own];
        const vec3 way = receivers.positions[other] - receivers.positions[own];
        const float height = glm::dot(way, normal);
        const float farthest = kHighest * receivers.footprints[own];
        const float length2 = glm::dot(way, way);
        return height > 0.0f && height * height > kSteepness * kSteepness * length2 &&
               length2 < farthest * farthest && receivers.seen(other) &&
               glm::dot(receivers.normals[other], normal) > kParallel;
    };
    parallelFor(image.height, [&](int y) {
        for (int x = 0; x < image.width; ++x) {
            const size_t own = image.index(x, y);
            bool crease = false;
            for (int v = std::max(y - kWindow, 0);
                 v <= std::min(y + kWindow, image.height - 1) && receivers.seen(own); ++v) {
                for (int u = std::max(x - kWindow, 0); u <= std::min(x + kWindow, image.width - 1);
                     ++u) {
                    crease = crease || stands_before(image.index(u, v), own);
                }
            }
            creases[own] = crease ? 1 : 0;
        }
    });
    return creases;
}

}  // namespace sheen
