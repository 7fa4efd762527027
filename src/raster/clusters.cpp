#include "raster/clusters.h"

#include <meshoptimizer.h>

#include <algorithm>
#include <array>
#include <map>
#include <unordered_map>

namespace sheen {
namespace {

constexpr size_t kMaxVertices = 255;  // meshoptimizer's limits
constexpr size_t kMaxTriangles = 512;
// Tolerated error of the coarser levels, relative to the scene's size, or to that of the cluster's
// surroundings where the scene is far larger than those.
constexpr float kLevelErrors[kLevelsOfDetail] = {0.0f, 4e-4f, 1.6e-3f, 6.4e-3f};
constexpr float kSurroundings = 256.0f;  // times the cluster's radius
// Separate pieces are put into one cluster only while it stays smaller than this share of the
// scene.
constexpr float kClusterSize = 0.06f;

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

// Connected pieces of one material.
std::vector<std::vector<uint32_t>> connectedPieces(const std::vector<uint32_t>& welded,
                                                   const std::vector<uint32_t>& triangles) {
    std::unordered_map<uint32_t, uint32_t> parent;
    const auto root = [&parent](uint32_t v) {
        parent.try_emplace(v, v);
        while (parent[v] != v) {
            v = parent[v] = parent[parent[v]];
        }
        return v;
    };
    for (uint32_t t : triangles) {
        const uint32_t* v = &welded[3 * static_cast<size_t>(t)];
        const uint32_t a = root(v[0]);
        parent[root(v[1])] = a;
        parent[root(v[2])] = a;
    }
    std::unordered_map<uint32_t, size_t> piece_of;
    std::vector<std::vector<uint32_t>> pieces;
    for (uint32_t t : triangles) {
        const auto [it, added] =
            piece_of.try_emplace(root(welded[3 * static_cast<size_t>(t)]), pieces.size());
        if (added) {
            pieces.emplace_back();
        }
        pieces[it->second].push_back(t);
    }
    return pieces;
}

using Corners = std::array<uint32_t, 3>;

// Splits one piece that is too large for a cluster into connected patches.
std::vector<std::vector<uint32_t>> splitIntoPatches(const Scene& scene,
                                                    const std::vector<uint32_t>& welded,
                                                    const std::vector<uint32_t>& triangles) {
    // The piece's own vertices, numbered anew: meshoptimizer's work grows with all that it is
    // given.
    std::vector<uint32_t> own;
    for (uint32_t t : triangles) {
        const uint32_t* v = &welded[3 * static_cast<size_t>(t)];
        own.insert(own.end(), v, v + 3);
    }
    std::sort(own.begin(), own.end());
    own.erase(std::unique(own.begin(), own.end()), own.end());
    std::vector<vec3> positions;
    for (uint32_t vertex : own) {
        positions.push_back(scene.positions[vertex]);
    }
    const auto number = [&own](uint32_t vertex) {
        return static_cast<uint32_t>(std::lower_bound(own.begin(), own.end(), vertex) -
                                     own.begin());
    };
    std::vector<uint32_t> indices;
    // meshoptimizer returns triangles by their vertices; these lead back. Twins are taken in turn,
    // but the two sides of a sheet, which are wound differently, are not mixed up.
    std::map<Corners, std::vector<uint32_t>> by_vertices;
    const auto key = [](uint32_t a, uint32_t b, uint32_t c) {
        return std::min({Corners{a, b, c}, Corners{b, c, a}, Corners{c, a, b}});
    };
    for (uint32_t t : triangles) {
        const uint32_t* v = &welded[3 * static_cast<size_t>(t)];
        const Corners c{number(v[0]), number(v[1]), number(v[2])};
        indices.insert(indices.end(), c.begin(), c.end());
        by_vertices[key(c[0], c[1], c[2])].push_back(t);
    }
    const size_t bound = meshopt_buildMeshletsBound(indices.size(), kMaxVertices, kMaxTriangles);
    std::vector<meshopt_Meshlet> meshlets(bound);
    std::vector<unsigned int> vertices(bound * kMaxVertices);
    std::vector<unsigned char> corners(bound * kMaxTriangles * 3);
    meshlets.resize(meshopt_buildMeshlets(
        meshlets.data(), vertices.data(), corners.data(), indices.data(), indices.size(),
        &positions[0].x, positions.size(), sizeof(vec3), kMaxVertices, kMaxTriangles, 0.0f));
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

// A patch by layers: of triangles at the same three places, such as the two sides of a sheet, each
// is in another one.
std::vector<std::vector<uint32_t>> layersOf(const std::vector<uint32_t>& welded,
                                            const std::vector<uint32_t>& patch) {
    std::map<Corners, std::vector<uint32_t>> at_places;
    const auto places = [&welded](uint32_t t) {
        const uint32_t* v = &welded[3 * static_cast<size_t>(t)];
        Corners sorted{v[0], v[1], v[2]};
        std::sort(sorted.begin(), sorted.end());
        return sorted;
    };
    for (uint32_t t : patch) {
        at_places[places(t)].push_back(t);
    }
    std::vector<std::vector<uint32_t>> layers;
    for (uint32_t t : patch) {
        // In the scene's order: a sheet's sides follow each other, in all or in each of its parts.
        const std::vector<uint32_t>& twins = at_places[places(t)];
        const auto layer = static_cast<size_t>(
            std::count_if(twins.begin(), twins.end(), [t](uint32_t other) { return other < t; }));
        layers.resize(std::max(layers.size(), layer + 1));
        layers[layer].push_back(t);
    }
    return layers;
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

// Coarser triangles of a patch, as scene vertices. Smooth shading and textures survive because a
// corner takes, of the vertices at its position, the one whose normal fits the new triangle best.
class Simplifier {
  public:
    Simplifier(const Scene& scene, const std::vector<uint32_t>& welded,
               const std::vector<uint32_t>& patch)
        : scene_(scene) {
        // A textured patch keeps its seams, where a coordinate jumps, as one whose corners have
        // colours does; others are welded.
        textured_ =
            scene.materials[scene.materials_of[patch[0]]].textured() || !scene.colors.empty();
        std::unordered_map<uint32_t, uint32_t> local_of;
        for (uint32_t t : patch) {
            for (int corner = 0; corner < 3; ++corner) {
                const uint32_t v = scene.triangles[t][corner];
                const uint32_t representative =
                    textured_ ? v
                              : welded[3 * static_cast<size_t>(t) + static_cast<size_t>(corner)];
                const auto [it, added] =
                    local_of.try_emplace(representative, static_cast<uint32_t>(positions_.size()));
                if (added) {
                    positions_.push_back(scene.positions[v]);
                    vertices_.emplace_back();
                }
                std::vector<uint32_t>& twins = vertices_[it->second];
                if (std::find(twins.begin(), twins.end(), v) == twins.end()) {
                    twins.push_back(v);
                }
                indices_.push_back(it->second);
            }
        }
        scale_ = meshopt_simplifyScale(&positions_[0].x, positions_.size(), sizeof(vec3));
    }

    // With an error of at most `error` scene units, which becomes the one that was made.
    std::vector<uvec3> simplify(float& error) const {
        std::vector<uint32_t> simple(indices_.size());
        float relative = 0.0f;
        simple.resize(meshopt_simplify(simple.data(), indices_.data(), indices_.size(),
                                       &positions_[0].x, positions_.size(), sizeof(vec3), 0,
                                       std::min(error / scale_, 1.0f), meshopt_SimplifyLockBorder,
                                       &relative));
        error = relative * scale_;
        std::vector<uvec3> triangles;
        for (size_t i = 0; i < simple.size(); i += 3) {
            const vec3 normal = glm::cross(positions_[simple[i + 1]] - positions_[simple[i]],
                                           positions_[simple[i + 2]] - positions_[simple[i]]);
            if (glm::dot(normal, normal) > 0.0f) {
                triangles.emplace_back(bestVertex(simple[i], normal),
                                       bestVertex(simple[i + 1], normal),
                                       bestVertex(simple[i + 2], normal));
            }
        }
        return triangles;
    }

  private:
    uint32_t bestVertex(uint32_t local, const vec3& normal) const {
        const std::vector<uint32_t>& twins = vertices_[local];
        return *std::max_element(twins.begin(), twins.end(), [&](uint32_t a, uint32_t b) {
            return glm::dot(scene_.normals[a], normal) < glm::dot(scene_.normals[b], normal);
        });
    }

    const Scene& scene_;
    bool textured_ = false;
    std::vector<vec3> positions_;                  // [local vertex]
    std::vector<std::vector<uint32_t>> vertices_;  // the scene's vertices there
    std::vector<uint32_t> indices_;
    float scale_ = 1.0f;
};

void appendCluster(const Scene& scene, const std::vector<uint32_t>& welded,
                   const std::vector<uint32_t>& patch, ClusteredMesh& mesh) {
    std::vector<uvec3> triangles;
    Bounds bounds;
    for (uint32_t t : patch) {
        triangles.push_back(scene.triangles[t]);
        for (int corner = 0; corner < 3; ++corner) {
            bounds.add(scene.positions[scene.triangles[t][corner]]);
        }
    }
    Cluster cluster;
    cluster.center = bounds.center();
    cluster.radius = 0.5f * bounds.size();
    cluster.levels[0] = appendLevel(triangles, patch, 0.0f, mesh);
    // One at a time: both sides of a sheet together are a closed surface, which has no border to
    // keep.
    std::vector<Simplifier> simplifiers;
    for (const std::vector<uint32_t>& layer : layersOf(welded, patch)) {
        simplifiers.emplace_back(scene, welded, layer);
    }
    const float size = std::min(scene.bounds.size(), kSurroundings * cluster.radius);
    for (int level = 1; level < kLevelsOfDetail; ++level) {
        cluster.levels[level] = cluster.levels[level - 1];
        std::vector<uvec3> coarse;
        float error = 0.0f;
        for (const Simplifier& simplifier : simplifiers) {
            float error_of_layer = kLevelErrors[level] * size;
            const std::vector<uvec3> layer = simplifier.simplify(error_of_layer);
            coarse.insert(coarse.end(), layer.begin(), layer.end());
            error = std::max(error, error_of_layer);
        }
        // A level that saves little is not worth lighting.
        if (!coarse.empty() && 4 * coarse.size() <= 3 * cluster.levels[level].count) {
            // All of one material, so any triangle of the patch stands for where they came from.
            cluster.levels[level] =
                appendLevel(coarse, std::vector<uint32_t>(coarse.size(), patch[0]), error, mesh);
        }
    }
    mesh.clusters.push_back(cluster);
}

// Appends clusters of one material: large pieces split, small ones packed with their neighbours.
void appendClusters(const Scene& scene, const std::vector<uint32_t>& welded,
                    const std::vector<uint32_t>& triangles, ClusteredMesh& mesh) {
    struct Piece {
        std::vector<uint32_t> triangles;
        Bounds bounds;
    };
    std::vector<Piece> small;
    for (std::vector<uint32_t>& piece : connectedPieces(welded, triangles)) {
        if (piece.size() > kMaxTriangles) {
            for (const std::vector<uint32_t>& patch : splitIntoPatches(scene, welded, piece)) {
                appendCluster(scene, welded, patch, mesh);
            }
            continue;
        }
        Bounds bounds;
        for (uint32_t t : piece) {
            for (int corner = 0; corner < 3; ++corner) {
                bounds.add(scene.positions[scene.triangles[t][corner]]);
            }
        }
        small.push_back({std::move(piece), bounds});
    }
    std::vector<vec3> centers;
    for (const Piece& piece : small) {
        centers.push_back(piece.bounds.center());
    }
    std::vector<uint32_t> rank(small.size());
    if (!small.empty()) {
        meshopt_spatialSortRemap(rank.data(), &centers[0].x, centers.size(), sizeof(vec3));
    }
    std::vector<uint32_t> order(small.size());
    for (size_t i = 0; i < small.size(); ++i) {
        order[rank[i]] = static_cast<uint32_t>(i);
    }
    std::vector<uint32_t> patch;
    Bounds bounds;
    for (uint32_t i : order) {
        Bounds together = bounds;
        together.add(small[i].bounds.lower);
        together.add(small[i].bounds.upper);
        if (!patch.empty() && (patch.size() + small[i].triangles.size() > kMaxTriangles ||
                               together.size() > kClusterSize * scene.bounds.size())) {
            appendCluster(scene, welded, patch, mesh);
            patch.clear();
            together = small[i].bounds;
        }
        patch.insert(patch.end(), small[i].triangles.begin(), small[i].triangles.end());
        bounds = together;
    }
    if (!patch.empty()) {
        appendCluster(scene, welded, patch, mesh);
    }
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
        if (!triangles.empty()) {
            appendClusters(scene, welded, triangles, mesh);
        }
    }
    return mesh;
}

}  // namespace sheen
