// Clusters: that they are the scene, and that their coarser levels keep to it.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <deque>
#include <limits>
#include <map>
#include <set>
#include <string>

#include "raster/clusters.h"
#include "test_scenes.h"

namespace sheen {
namespace {

// ---- Scenes -------------------------------------------------------------------------------------

// A wavy sheet of n x n squares, each with four vertices of its own whose normals differ from its
// neighbours'; height 0: flat.
void addCreasedSheet(Scene& scene, const vec3& corner, int n, float height, uint32_t material) {
    Random random(static_cast<uint32_t>(n));
    const auto point = [&](int i, int j) {
        const float x = static_cast<float>(i) / static_cast<float>(n);
        const float z = static_cast<float>(j) / static_cast<float>(n);
        return corner + vec3(x, height * std::sin(5.0f * x) * std::cos(4.0f * z), z);
    };
    for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n; ++j) {
            const vec3 normal = random.direction(vec3(0, 1, 0));
            const uint32_t base = addVertex(scene, point(i, j), normal);
            addVertex(scene, point(i, j + 1), normal);
            addVertex(scene, point(i + 1, j + 1), normal);
            addVertex(scene, point(i + 1, j), normal);
            scene.triangles.emplace_back(base, base + 1, base + 2);
            scene.triangles.emplace_back(base, base + 2, base + 3);
            scene.materials_of.insert(scene.materials_of.end(), 2, material);
        }
    }
}

// Triangles far smaller than the distances between them.
void addCrumbs(Scene& scene, int count, uint32_t material) {
    Random random(static_cast<uint32_t>(count));
    for (int i = 0; i < count; ++i) {
        const vec3 p = random.point(-2.0f, 2.0f);
        const vec3 n = random.direction();
        const uint32_t base = addVertex(scene, p, n);
        addVertex(scene, p + 0.01f * random.direction(), n);
        addVertex(scene, p + 0.01f * random.direction(), n);
        scene.triangles.emplace_back(base, base + 1, base + 2);
        scene.materials_of.push_back(material);
    }
}

// Every step-th triangle once more, turned over.
void addBackSides(Scene& scene, size_t step) {
    const size_t count = scene.triangles.size();
    for (size_t t = 0; t < count; t += step) {
        const uvec3 v = scene.triangles[t];
        scene.triangles.emplace_back(v.x, v.z, v.y);
        scene.materials_of.push_back(scene.materials_of[t]);
    }
}

// Every triangle once more.
void addDuplicates(Scene& scene) {
    scene.triangles.insert(scene.triangles.end(), scene.triangles.begin(), scene.triangles.end());
    scene.materials_of.insert(scene.materials_of.end(), scene.materials_of.begin(),
                              scene.materials_of.end());
}

struct NamedScene {
    std::string name;
    Scene scene;
};

std::deque<NamedScene> scenes() {
    std::deque<NamedScene> all;  // references to its elements stay valid
    const auto add = [&all](const char* name) -> Scene& {
        all.push_back({name, {}});
        addMaterial(all.back().scene, diffuseParams(vec3(0.5f)));
        return all.back().scene;
    };
    addSphere(add("sphere"), vec3(0), 1.0f, 30, 0);
    addCreasedSheet(add("flat sheet"), vec3(0), 30, 0.0f, 0);
    addCreasedSheet(add("creased sheet"), vec3(0), 40, 0.05f, 0);
    addCrumbs(add("crumbs"), 1500, 0);

    Scene& several = add("several meshes");
    const uint32_t other = addMaterial(several, diffuseParams(vec3(0.5f)));
    addSphere(several, vec3(0, 1, 0), 0.5f, 20, 0);
    addSphere(several, vec3(0.7f, 1, 0), 0.5f, 12, other);
    addCreasedSheet(several, vec3(-0.5f, 0, -0.5f), 20, 0.02f, 0);
    addBox(several, vec3(-1), vec3(1, 2, 1), other, true);
    addCrumbs(several, 100, other);

    Scene& textured = add("textured sphere");
    textured.materials[0].textures[shared::TEXTURE_BASE_COLOR].texture = 0;
    addSphere(textured, vec3(0), 1.0f, 20, 0);

    Scene& two_sided = add("two-sided sheet");
    addCreasedSheet(two_sided, vec3(0), 20, 0.05f, 0);
    addBackSides(two_sided, 1);

    Scene& partly = add("partly two-sided sphere");
    addSphere(partly, vec3(0), 1.0f, 20, 0);
    addBackSides(partly, 3);

    Scene& duplicates = add("duplicates");
    addSphere(duplicates, vec3(0), 1.0f, 20, 0);
    addDuplicates(duplicates);

    Scene& degenerate = add("with triangles without area");
    addCreasedSheet(degenerate, vec3(0), 20, 0.05f, 0);
    for (uint32_t v = 0; v < 60; v += 4) {
        degenerate.triangles.emplace_back(v, v, v + 1);
        degenerate.triangles.emplace_back(v, v, v);
        degenerate.materials_of.insert(degenerate.materials_of.end(), 2, 0u);
    }
    return all;
}

// ---- Geometry -----------------------------------------------------------------------------------

constexpr double kRounding = 1e-6;  // coordinates of order one

std::vector<uvec3> trianglesOf(const ClusteredMesh& mesh, const LevelOfDetail& level) {
    const auto first = mesh.triangles.begin() + level.first;
    return {first, first + level.count};
}

using Triangle = std::array<glm::dvec3, 3>;

double distanceToSegment(const glm::dvec3& p, const glm::dvec3& a, const glm::dvec3& b) {
    const glm::dvec3 d = b - a;
    const double length2 = glm::dot(d, d);
    const double t = length2 > 0.0 ? glm::clamp(glm::dot(p - a, d) / length2, 0.0, 1.0) : 0.0;
    return glm::length(p - a - t * d);
}

double distanceToTriangle(const glm::dvec3& p, const Triangle& v) {
    const glm::dvec3 n = glm::cross(v[1] - v[0], v[2] - v[0]);
    bool above = glm::dot(n, n) > 0.0;
    double nearest = std::numeric_limits<double>::infinity();
    for (size_t k = 0; k < 3; ++k) {
        const glm::dvec3 &a = v[k], &b = v[(k + 1) % 3];
        above = above && glm::dot(glm::cross(b - a, p - a), n) >= 0.0;
        nearest = std::min(nearest, distanceToSegment(p, a, b));
    }
    return above ? std::abs(glm::dot(p - v[0], n)) / glm::length(n) : nearest;
}

Triangle corners(const Scene& scene, const uvec3& t) {
    return {glm::dvec3(scene.positions[t.x]), glm::dvec3(scene.positions[t.y]),
            glm::dvec3(scene.positions[t.z])};
}

using Point = std::array<float, 3>;
using Edge = std::pair<Point, Point>;  // in order

// Edges that one triangle uses. They are known by where they are, not by their vertices; triangles
// without three different corners have none.
std::set<Edge> borderEdges(const Scene& scene, const std::vector<uvec3>& triangles) {
    std::map<Edge, int> uses;
    for (const uvec3& t : triangles) {
        Point p[3];
        for (int k = 0; k < 3; ++k) {
            const vec3& v = scene.positions[t[k]];
            p[k] = {v.x, v.y, v.z};
        }
        if (p[0] != p[1] && p[1] != p[2] && p[2] != p[0]) {
            for (int k = 0; k < 3; ++k) {
                ++uses[std::minmax(p[k], p[(k + 1) % 3])];
            }
        }
    }
    std::set<Edge> border;
    for (const auto& [edge, count] : uses) {
        if (count == 1) {
            border.insert(edge);
        }
    }
    return border;
}

glm::dvec3 toVector(const Point& p) { return {p[0], p[1], p[2]}; }

bool liesOn(const Edge& edge, const std::set<Edge>& others) {
    const glm::dvec3 a = toVector(edge.first), b = toVector(edge.second);
    return std::any_of(others.begin(), others.end(), [&](const Edge& other) {
        const glm::dvec3 c = toVector(other.first), d = toVector(other.second);
        return std::max(distanceToSegment(a, c, d), distanceToSegment(b, c, d)) <= kRounding;
    });
}

double area(const Scene& scene, const uvec3& t) {
    const Triangle v = corners(scene, t);
    return 0.5 * glm::length(glm::cross(v[1] - v[0], v[2] - v[0]));
}

double area(const Scene& scene, const std::vector<uvec3>& triangles) {
    double sum = 0.0;
    for (const uvec3& t : triangles) {
        sum += area(scene, t);
    }
    return sum;
}

// Greatest distance of points of some triangles from others.
double farthest(const Scene& scene, const std::vector<uvec3>& from, const std::vector<uvec3>& to) {
    std::vector<Triangle> surface;
    for (const uvec3& t : to) {
        surface.push_back(corners(scene, t));
    }
    double result = 0.0;
    for (const uvec3& t : from) {
        const Triangle v = corners(scene, t);
        for (const glm::dvec3& weights :
             {glm::dvec3(1, 0, 0), glm::dvec3(0.5, 0.5, 0), glm::dvec3(0.5, 0, 0.5),
              glm::dvec3(0, 0.5, 0.5), glm::dvec3(1.0 / 3.0)}) {
            const glm::dvec3 p = weights.x * v[0] + weights.y * v[1] + weights.z * v[2];
            double nearest = std::numeric_limits<double>::infinity();
            for (const Triangle& s : surface) {
                nearest = std::min(nearest, distanceToTriangle(p, s));
            }
            result = std::max(result, nearest);
        }
    }
    return result;
}

// ---- Tests --------------------------------------------------------------------------------------

// A level's error is a mean over the planes that a vertex stands for; single points lie further
// off. Measured at the points compared here: at most XX times.
constexpr double kFarthest = 3.0;

TEST(Clusters, FinestLevelsAreTheScene) {
    for (const auto& [name, scene] : scenes()) {
        SCOPED_TRACE(name);
        const ClusteredMesh mesh = buildClusters(scene);
        ASSERT_EQ(mesh.triangles.size(), mesh.scene_triangles.size());
        std::vector<int> uses(scene.triangles.size(), 0);
        for (const Cluster& cluster : mesh.clusters) {
            const LevelOfDetail& finest = cluster.levels[0];
            EXPECT_EQ(finest.error, 0.0f);
            for (uint32_t i = finest.first; i < finest.first + finest.count; ++i) {
                const uint32_t t = mesh.scene_triangles[i];
                ASSERT_LT(t, scene.triangles.size());
                EXPECT_EQ(mesh.triangles[i], scene.triangles[t]);
                ++uses[t];
            }
        }
        EXPECT_EQ(std::count(uses.begin(), uses.end(), 1), std::ssize(uses));
    }
}

TEST(Clusters, EmptySceneHasNone) {
    for (int materials : {0, 2}) {
        Scene scene;
        scene.materials.resize(static_cast<size_t>(materials));
        const ClusteredMesh mesh = buildClusters(scene);
        EXPECT_TRUE(mesh.clusters.empty());
        EXPECT_TRUE(mesh.triangles.empty());
    }
}

TEST(Clusters, OfASceneWithoutExtent) {
    Scene scene;
    addMaterial(scene, diffuseParams(vec3(0.5f)));
    addVertex(scene, vec3(1, 2, 3), vec3(0, 1, 0));
    scene.triangles.emplace_back(0u, 0u, 0u);
    scene.materials_of.push_back(0);
    const ClusteredMesh mesh = buildClusters(scene);
    ASSERT_EQ(mesh.clusters.size(), 1u);
    for (const LevelOfDetail& level : mesh.clusters[0].levels) {
        EXPECT_EQ(level.count, 1u);
        EXPECT_EQ(level.error, 0.0f);
    }
}

TEST(Clusters, AreOfOneMaterialInsideTheirSpheres) {
    for (const auto& [name, scene] : scenes()) {
        SCOPED_TRACE(name);
        const ClusteredMesh mesh = buildClusters(scene);
        for (const Cluster& cluster : mesh.clusters) {
            const uint32_t material =
                scene.materials_of[mesh.scene_triangles[cluster.levels[0].first]];
            for (const LevelOfDetail& level : cluster.levels) {
                for (uint32_t i = level.first; i < level.first + level.count; ++i) {
                    EXPECT_EQ(scene.materials_of[mesh.scene_triangles[i]], material);
                    for (const glm::dvec3& corner : corners(scene, mesh.triangles[i])) {
                        EXPECT_LE(glm::length(corner - glm::dvec3(cluster.center)),
                                  cluster.radius + kRounding);
                    }
                }
            }
        }
    }
}

TEST(Clusters, LevelsNeverGrowAndOnlySomeShapesShrink) {
    for (const auto& [name, scene] : scenes()) {
        SCOPED_TRACE(name);
        const ClusteredMesh mesh = buildClusters(scene);
        uint32_t finest = 0, coarsest = 0;
        for (const Cluster& cluster : mesh.clusters) {
            for (int l = 1; l < kLevelsOfDetail; ++l) {
                EXPECT_LE(cluster.levels[l].count, cluster.levels[l - 1].count);
                EXPECT_GE(cluster.levels[l].error, cluster.levels[l - 1].error);
                EXPECT_GT(cluster.levels[l].count, 0u);
            }
            finest += cluster.levels[0].count;
            coarsest += cluster.levels[kLevelsOfDetail - 1].count;
        }
        if (name == "crumbs") {
            EXPECT_EQ(coarsest, finest);  // nothing but borders
        } else {
            EXPECT_LT(4 * coarsest, 3 * finest);
        }
    }
}

// Levels that are not simply the finer one again.
std::vector<LevelOfDetail> coarserLevels(const Cluster& cluster) {
    std::vector<LevelOfDetail> levels;
    for (int l = 1; l < kLevelsOfDetail; ++l) {
        if (cluster.levels[l].first != cluster.levels[l - 1].first) {
            levels.push_back(cluster.levels[l]);
        }
    }
    return levels;
}

// A border edge stays one, unless the border is straight: then it may be part of a longer one.
TEST(Clusters, CoarserLevelsKeepTheBorder) {
    for (const auto& [name, scene] : scenes()) {
        SCOPED_TRACE(name);
        const ClusteredMesh mesh = buildClusters(scene);
        for (const Cluster& cluster : mesh.clusters) {
            const std::set<Edge> border = borderEdges(scene, trianglesOf(mesh, cluster.levels[0]));
            for (const LevelOfDetail& level : coarserLevels(cluster)) {
                const std::set<Edge> kept = borderEdges(scene, trianglesOf(mesh, level));
                for (const Edge& edge : border) {
                    EXPECT_TRUE(kept.contains(edge) || liesOn(edge, kept));
                }
                if (name == "sphere") {
                    EXPECT_EQ(kept, border);  // nothing is straight
                }
            }
        }
    }
}

TEST(Clusters, CoarserLevelsLieOnTheSurface) {
    for (const auto& [name, scene] : scenes()) {
        SCOPED_TRACE(name);
        const ClusteredMesh mesh = buildClusters(scene);
        for (const Cluster& cluster : mesh.clusters) {
            const std::vector<uvec3> finest = trianglesOf(mesh, cluster.levels[0]);
            for (const LevelOfDetail& level : coarserLevels(cluster)) {
                const double limit = kFarthest * level.error + kRounding;
                const std::vector<uvec3> coarse = trianglesOf(mesh, level);
                // Both ways: neither bulges nor holes.
                EXPECT_LE(farthest(scene, coarse, finest), limit);
                EXPECT_LE(farthest(scene, finest, coarse), limit);
            }
        }
    }
}

TEST(Clusters, CoarserTrianglesHaveAnAreaAndCoverWhatTheFinestDo) {
    for (const auto& [name, scene] : scenes()) {
        SCOPED_TRACE(name);
        const ClusteredMesh mesh = buildClusters(scene);
        for (const Cluster& cluster : mesh.clusters) {
            for (const LevelOfDetail& level : coarserLevels(cluster)) {
                for (const uvec3& t : trianglesOf(mesh, level)) {
                    EXPECT_GT(area(scene, t), 0.0);
                }
                if (name == "flat sheet") {
                    // No holes. (Folds there are: meshoptimizer may turn single triangles over.)
                    EXPECT_GE(area(scene, trianglesOf(mesh, level)),
                              area(scene, trianglesOf(mesh, cluster.levels[0])) - kRounding);
                }
            }
        }
    }
}

}  // namespace
}  // namespace sheen
