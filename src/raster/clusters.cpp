#include "raster/clusters.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <array>
#include <map>
#include <unordered_map>

namespace sheen {
namespace {

constexpr size_t kMaxVertices = 255;   // meshoptimizer's limits
constexpr size_t kMaxTriangles = 512;
// Tolerated error of the coarser levels, relative to the cluster's size.
constexpr float kLevelErrors[kLevelsOfDetail] = {0.0f, 0.02f, 0.1f};

// Maps each vertex to the first one at the same position, so that patches hang together across
// edges where only normals or texture coordinates are split.
std::vector<uint32_t> weldedIndices(const Scene& scene) {
    std::vector<uint32_t> indices;
    for (const uvec3& t : scene.triangles) {
        indices.insert(indices.end(), {t.x, t.y, t.z});
    }
    std::vector<uint32_t> welded(indices.size());
    if (!indices.empty()) {
        meshopt_generateShadowIndexBuffer(welded.data(), indices.data(), indices.size(),
                                          scene.positions.data(), scene.positions.size(),
                                          sizeof(vec3), sizeof(vec3));
    }
    return welded;
}

// Patches of one material: lists of its triangles.
std::vector<std::vector<uint32_t>> splitIntoPatches(const Scene& scene,
                                                    const std::vector<uint32_t>& welded,
                                                    const std::vector<uint32_t>& triangles) {
    std::vector<uint32_t> indices;
    // meshoptimizer returns triangles by their vertices; these lead back. Twins are taken in turn.
    std::map<std::array<uint32_t, 3>, std::vector<uint32_t>> by_vertices;
    const auto key = [](uint32_t a, uint32_t b, uint32_t c) {
        std::array<uint32_t, 3> k{a, b, c};
        std::sort(k.begin(), k.end());
        return k;
    };
    for (uint32_t t : triangles) {
        const uint32_t* v = &welded[3 * static_cast<size_t>(t)];
        indices.insert(indices.end(), v, v + 3);
        by_vertices[key(v[0], v[1], v[2])].push_back(t);
    }
    const size_t bound = meshopt_buildMeshletsBound(indices.size(), kMaxVertices, kMaxTriangles);
    std::vector<meshopt_Meshlet> meshlets(bound);
    std::vector<unsigned int> vertices(bound * kMaxVertices);
    std::vector<unsigned char> corners(bound * kMaxTriangles * 3);
    meshlets.resize(meshopt_buildMeshlets(meshlets.data(), vertices.data(), corners.data(),
                                          indices.data(), indices.size(), &scene.positions[0].x,
                                          scene.positions.size(), sizeof(vec3), kMaxVertices,
                                          kMaxTriangles, 0.0f));
    std::vector<std::vector<uint32_t>> patches;
    for (const meshopt_Meshlet& m : meshlets) {
        std::vector<uint32_t> patch;
        for (size_t i = 0; i < m.triangle_count; ++i) {
            const auto vertex = [&](size_t corner) {
                return vertices[m.vertex_offset + corners[m.triangle_offset + 3 * i + corner]];
            };
            std::vector<uint32_t>& candidates = by_vertices[key(vertex(0), vertex(1), vertex(2))];
            patch.push_back(candidates.back());
            candidates.pop_back();
        }
        patches.push_back(std::move(patch));
    }
    return patches;
}

// Appends triangles as one level.
LevelOfDetail appendLevel(const std::vector<uvec3>& triangles,
                          const std::vector<uint32_t>& scene_triangles, float error,
                          ClusteredMesh& mesh) {
    const auto first = static_cast<uint32_t>(mesh.triangles.size());
    mesh.triangles.insert(mesh.triangles.end(), triangles.begin(), triangles.end());
    mesh.scene_triangles.insert(mesh.scene_triangles.end(), scene_triangles.begin(),
                                scene_triangles.end());
    return {.first = first, .count = static_cast<uint32_t>(triangles.size()), .error = error};
}

void appendCluster(const Scene& scene, const std::vector<uint32_t>& patch, ClusteredMesh& mesh) {
    // The patch on its own, so that the simplifier's cost and scale are the patch's.
    std::unordered_map<uint32_t, uint32_t> local_of;
    std::vector<uint32_t> vertex_of;
    std::vector<vec3> positions;
    std::vector<uint32_t> indices;
    std::vector<uvec3> triangles;
    Bounds bounds;
    for (uint32_t t : patch) {
        triangles.push_back(scene.triangles[t]);
        for (int corner = 0; corner < 3; ++corner) {
            const uint32_t v = scene.triangles[t][corner];
            const auto [it, added] = local_of.try_emplace(v, static_cast<uint32_t>(vertex_of.size()));
            if (added) {
                vertex_of.push_back(v);
                positions.push_back(scene.positions[v]);
                bounds.add(scene.positions[v]);
            }
            indices.push_back(it->second);
        }
    }
    Cluster cluster;
    cluster.center = bounds.center();
    cluster.radius = 0.5f * bounds.size();
    cluster.levels[0] = appendLevel(triangles, patch, 0.0f, mesh);
    const float scale =
        meshopt_simplifyScale(&positions[0].x, positions.size(), sizeof(vec3));
    for (int level = 1; level < kLevelsOfDetail; ++level) {
        cluster.levels[level] = cluster.levels[level - 1];
        std::vector<uint32_t> simple(indices.size());
        float error = 0.0f;
        simple.resize(meshopt_simplify(simple.data(), indices.data(), indices.size(),
                                       &positions[0].x, positions.size(), sizeof(vec3), 0,
                                       kLevelErrors[level], meshopt_SimplifyLockBorder, &error));
        // A level that saves little is not worth lighting.
        if (simple.empty() || 3 * cluster.levels[level].count * 3 < simple.size() * 4) {
            continue;
        }
        std::vector<uvec3> coarse;
        for (size_t i = 0; i < simple.size(); i += 3) {
            coarse.emplace_back(vertex_of[simple[i]], vertex_of[simple[i + 1]],
                                vertex_of[simple[i + 2]]);
        }
        // All of one material, so any triangle of the patch stands for where they came from.
        cluster.levels[level] =
            appendLevel(coarse, std::vector<uint32_t>(coarse.size(), patch[0]), error * scale, mesh);
    }
    mesh.clusters.push_back(cluster);
}

}  // namespace

ClusteredMesh buildClusters(const Scene& scene) {
    ClusteredMesh mesh;
    const std::vector<uint32_t> welded = weldedIndices(scene);
    std::vector<std::vector<uint32_t>> by_material(scene.materials.size());
    for (size_t t = 0; t < scene.triangles.size(); ++t) {
        by_material[scene.materials_of[t]].push_back(static_cast<uint32_t>(t));
    }
    for (const std::vector<uint32_t>& triangles : by_material) {
        if (triangles.empty()) {
            continue;
        }
        for (const std::vector<uint32_t>& patch : splitIntoPatches(scene, welded, triangles)) {
            appendCluster(scene, patch, mesh);
        }
    }
    return mesh;
}

}  // namespace sheen
