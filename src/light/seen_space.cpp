#include "light/seen_space.h"

#include <algorithm>

namespace sheen {

SeenSpace::SeenSpace(const std::vector<vec3>& points) {
    Bounds box;
    for (const vec3& p : points) {
        box.add(p);
    }
    if (points.empty()) {
        return;
    }
    const vec3 extent = box.upper - box.lower;
    const float longest = std::max({extent.x, extent.y, extent.z});
    size_ = longest > 0.0f ? longest / kCells : 1.0f;
    lower_ = box.lower - vec3(size_);
    counts_ = ivec3(extent / size_) + 3;
    filled_.resize(static_cast<size_t>(counts_.x) * static_cast<size_t>(counts_.y) *
                   static_cast<size_t>(counts_.z));
    for (const vec3& p : points) {
        const ivec3 c = cellOf(p);
        for (int z = std::max(c.z - 1, 0); z <= std::min(c.z + 1, counts_.z - 1); ++z) {
            for (int y = std::max(c.y - 1, 0); y <= std::min(c.y + 1, counts_.y - 1); ++y) {
                for (int x = std::max(c.x - 1, 0); x <= std::min(c.x + 1, counts_.x - 1); ++x) {
                    filled_[static_cast<size_t>((z * counts_.y + y) * counts_.x + x)] = 1;
                }
            }
        }
    }
}

ivec3 SeenSpace::cellOf(const vec3& p) const { return ivec3(glm::floor((p - lower_) / size_)); }

bool SeenSpace::contains(const vec3& p) const {
    const vec3 scaled = (p - lower_) / size_;
    if (!glm::all(glm::greaterThanEqual(scaled, vec3(0.0f))) ||
        !glm::all(glm::lessThan(scaled, vec3(counts_)))) {
        return false;
    }
    const ivec3 c(scaled);
    return filled_[static_cast<size_t>((c.z * counts_.y + c.y) * counts_.x + c.x)] != 0;
}

}  // namespace sheen
