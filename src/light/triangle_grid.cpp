#include "light/triangle_grid.h"

#include <cmath>

namespace sheen {

std::vector<uint32_t> gridDivisions(const Scene& scene, const std::vector<Bounds>& near,
                                    float share, size_t budget) {
    const auto count = static_cast<size_t>(scene.triangleCount());
    std::vector<float> wanted(count);
    for (size_t i = 0; i < count; ++i) {
        Bounds reach;
        for (int corner = 0; corner < 3; ++corner) {
            reach.add(scene.positions[scene.triangles[i][corner]]);
        }
        float size = scene.bounds.size();
        for (const Bounds& box : near) {
            const bool apart = glm::any(glm::greaterThan(reach.lower, box.upper)) ||
                               glm::any(glm::greaterThan(box.lower, reach.upper));
            size = apart ? size : std::min(size, box.size());
        }
        const float edge = TriangleEdges(scene, static_cast<uint32_t>(i)).longestEdge();
        wanted[i] = std::min(edge / (share * size), 1.0f / share);
    }
    std::vector<uint32_t> result(count);
    for (float factor = 1.0f;; factor *= 1.1f) {
        size_t cells = 0;
        for (size_t i = 0; i < count; ++i) {
            result[i] = static_cast<uint32_t>(std::max(std::ceil(wanted[i] / factor), 1.0f));
            cells += TriangleGrid{result[i]}.cellCount();
        }
        if (cells <= std::max(budget, count)) {
            return result;
        }
    }
}

}  // namespace sheen
