// Charts: pieces of surface that can be laid flat or unrolled, grown greedily from the largest
// triangle on, by normals alone.
#pragma once

#include <array>
#include <vector>

#include "scene/scene.h"

namespace sheen {

/// Triangles that share edges, and face about one way, projected onto a plane, or curve about one
/// axis, unrolled. None lies over another.
struct UvChart {
    std::vector<uint32_t> triangles;
    std::vector<std::array<glm::dvec2, 3>>
        corners;  ///< [of the above], scene units; from (0, 0) on
    glm::dvec2 extent{0.0};
};

/// All triangles, each in one chart, no longer or wider than `largest`, scene units, but for single
/// triangles that are.
std::vector<UvChart> makeCharts(const Scene& scene, double largest = kInfinity);

/// Numbers of the places that vertices stand at: the same for those of the same place.
std::vector<uint32_t> placesOf(const Scene& scene);

}  // namespace sheen
