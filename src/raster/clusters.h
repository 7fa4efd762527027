// Clusters: connected patches of one material that are drawn or culled together, each with coarser
// versions of itself for views whose texels are larger than its triangles.
#pragma once

#include <cstdint>
#include <vector>

#include "scene/scene.h"

namespace sheen {

/// A run of triangles in the order of ClusteredMesh::triangles. The error is a mean over the planes
/// that a vertex stands for: single points lie up to about three times as far off.
struct LevelOfDetail {
    uint32_t first = 0;
    uint32_t count = 0;
    float error = 0;  ///< distance from the true surface, scene units; 0 for the finest
};

constexpr int kLevelsOfDetail = 4;

struct Cluster {
    vec3 center{};
    float radius = 0;
    LevelOfDetail levels[kLevelsOfDetail];  ///< finest first; equal ones where none is coarser
};

/// Indices into the scene's vertices, and the triangle of the scene each triangle is or came from.
struct ClusteredMesh {
    std::vector<Cluster> clusters;
    std::vector<uvec3> triangles;
    std::vector<uint32_t> scene_triangles;
};

/// The finest levels together are exactly the scene's triangles. Coarser ones keep the cluster's
/// border, so that neighbours of different levels still meet; only a straight piece of it may
/// become one edge.
ClusteredMesh buildClusters(const Scene& scene);

}  // namespace sheen
