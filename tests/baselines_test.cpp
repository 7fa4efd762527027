// Ward's records against closed forms and finite differences, the octree against all records.
#include <gtest/gtest.h>

#include "baselines/ward_octree.h"
#include "test_reference.h"

namespace sheen {
namespace {

// Sums of a few thousand floats.
constexpr float kRounding = 1e-4f;
// Edges of what is seen cross cells of 96 rings; a gradient is measured over a finite distance.
constexpr float kGradientError = 0.08f;

// A point of a surface that scatters nothing here: only its place and normals matter.
Surface pointAt(const vec3& p, const vec3& n) {
    Surface s;
    s.position = p;
    s.n_g = s.n = s.wo = n;
    s.offset = 1e-5f;
    return s;
}

WardRecord gather(const RayScene& rays, const vec3& p, const vec3& n, int rings) {
    Counters counters;
    return gatherRecord(rays, Lights(rays.scene()), pointAt(p, n), WardStrata(rings), 7, counters);
}

// Beside and above the origin a panel, lit from below; a black tile hides part of it.
Scene panelAndTile() {
    Scene scene;
    const uint32_t black = addMaterial(scene, diffuseParams(vec3(0.0f)));
    const uint32_t panel = addMaterial(scene, diffuseParams(vec3(0.9f, 0.6f, 0.3f)));
    addQuad(scene, vec3(0.2f, 1.0f, -0.5f), vec3(1.2f, 0, 0), vec3(0, 0, 1.0f), panel);
    addQuad(scene, vec3(0.5f, 0.4f, -0.1f), vec3(0.2f, 0, 0), vec3(0, 0, 0.7f), black);
    scene.lights.push_back(directionalLight(vec3(0, 1, 0), vec3(10.0f)));
    return scene;
}

TEST(WardRecord, FurnaceGivesPiTimesTheRadianceAndNoGradient) {
    const vec3 radiance(1.0f, 2.0f, 0.5f);
    Scene scene;
    scene.environment.texels = Image<vec3>(1, 1, radiance);
    const RayScene rays(scene);
    Random random(1);
    for (int i = 0; i < 8; ++i) {
        const WardRecord r = gather(rays, random.point(-0.9f, 0.9f), random.direction(), 8);
        for (int c = 0; c < 3; ++c) {
            const float E = kPi * radiance[c];
            EXPECT_NEAR(r.irradiance[c], E, kRounding * E);
            EXPECT_LT(glm::length(r.rotation[c]), kRounding * E);
            EXPECT_EQ(r.translation[c], vec3(0.0f));
        }
        EXPECT_EQ(r.radius, kInfinity);
    }
}

TEST(WardRecord, UniformRadianceAtAnyDepthsHasNoGradient) {
    const WardStrata strata(9);
    Random random(2);
    std::vector<WardCell> cells(static_cast<size_t>(strata.count()));
    for (WardCell& cell : cells) {
        cell = {.radiance = vec3(4.0f), .distance = random.uniform(0.01f, 100.0f)};
    }
    const WardRecord r = integrateCells(strata, cells, random.rotation());
    EXPECT_EQ(r.translation, mat3(0.0f));
    EXPECT_LT(glm::length(r.rotation[0]), kRounding * r.irradiance.x);
}

TEST(WardRecord, HarmonicMeanDistance) {
    const WardStrata strata(4);
    std::vector<WardCell> cells(static_cast<size_t>(strata.count()));
    for (size_t i = 0; i < cells.size(); ++i) {
        cells[i].distance = i % 2 == 0 ? 2.0f : kInfinity;  // half of it sees nothing
    }
    EXPECT_NEAR(integrateCells(strata, cells, mat3(1.0f)).radius, 4.0f, 0.2f);
}

TEST(WardRecord, NothingSeen) {
    const Scene scene;
    const RayScene rays(scene);
    const WardRecord r = gather(rays, vec3(1), vec3(0, 1, 0), 4);
    EXPECT_EQ(r.irradiance, vec3(0.0f));
    EXPECT_EQ(r.translation, mat3(0.0f));
    EXPECT_EQ(r.radius, kInfinity);
}

// The nearest surface moves a wall between two cells: a cell that points below the surface, where
// nothing is, must not count as near.
TEST(WardRecord, CellsBelowTheSurfaceMoveNothing) {
    const WardStrata strata(6);
    std::vector<WardCell> cells(static_cast<size_t>(strata.count()),
                                {.radiance = vec3(1.0f), .distance = 3.0f});
    for (int column = 0; column < strata.columns / 2; ++column) {
        cells[static_cast<size_t>(column * strata.rows + strata.rows - 1)] = {.distance = 0.0f};
    }
    const WardRecord r = integrateCells(strata, cells, mat3(1.0f));
    EXPECT_EQ(r.translation, mat3(0.0f));
    EXPECT_TRUE(std::isfinite(r.radius));
}

TEST(WardRecord, TranslationGradientIsTheFiniteDifference) {
    const Scene scene = panelAndTile();
    const RayScene rays(scene);
    const vec3 up(0, 1, 0);
    const float step = 0.04f;
    for (const vec3& p : {vec3(0.0f), vec3(-0.3f, 0, 0.4f), vec3(0.9f, 0, 0.7f)}) {
        const WardRecord r = gather(rays, p, up, 96);
        for (const vec3& axis : {vec3(1, 0, 0), vec3(0, 0, 1)}) {
            const float change = gather(rays, p + step * axis, up, 160).irradiance.x -
                                 gather(rays, p - step * axis, up, 160).irradiance.x;
            const float scale = glm::length(r.translation[0]);
            ASSERT_GT(scale, 0.1f);
            EXPECT_NEAR(glm::dot(r.translation[0], axis), change / (2.0f * step),
                        kGradientError * scale);
        }
    }
}

TEST(WardRecord, RotationGradientIsTheFiniteDifference) {
    const Scene scene = panelAndTile();
    const RayScene rays(scene);
    const float step = 0.05f;
    const WardRecord r = gather(rays, vec3(0, 0.1f, 0), vec3(0, 1, 0), 96);
    for (const vec3& axis : {vec3(1, 0, 0), vec3(0, 0, 1)}) {
        const auto tilted = [&](float t) { return glm::normalize(vec3(0, 1, 0) + t * axis); };
        const float change = gather(rays, r.position, tilted(step), 160).irradiance.x -
                             gather(rays, r.position, tilted(-step), 160).irradiance.x;
        EXPECT_NEAR(glm::dot(r.rotation[0], axis), change / (2.0f * step),
                    kGradientError * glm::length(r.rotation[0]));
    }
}

WardRecord randomRecord(Random& random) {
    WardRecord r;
    r.position = random.point(-1.0f, 1.0f);
    r.normal = glm::normalize(vec3(0, 1, 0) + 0.2f * random.direction());
    r.radius = std::exp(random.uniform(-6.0f, 1.0f));
    r.irradiance = random.point(0.1f, 1.0f);
    r.translation = 0.1f * random.rotation();
    return r;
}

TEST(WardOctree, FindsWhatALookAtAllRecordsFinds) {
    Random random(3);
    const float accuracy = 0.8f;
    WardOctree octree({.lower = vec3(-1), .upper = vec3(1)}, accuracy);
    for (int i = 0; i < 2000; ++i) {
        octree.insert(randomRecord(random), 1e-3f);
    }
    int served = 0;
    for (int i = 0; i < 4000; ++i) {
        // Beside a record, and outside of the bounds too.
        const WardRecord& near = octree.records()[static_cast<size_t>(i) % 2000];
        const vec3 p =
            near.position + 0.5f * near.radius * glm::cross(near.normal, random.direction());
        const vec3 n = glm::normalize(near.normal + 0.1f * random.direction());
        for (const float a : {accuracy, 0.5f * accuracy}) {
            int count = 0;
            float weight = 0.0f;
            for (const WardRecord& r : octree.records()) {
                const float error = wardError(r, p, n);
                count += error < a ? 1 : 0;
                weight += std::max(0.0f, 1.0f - error / a);
            }
            const Interpolated found = octree.lookup(p, n, a);
            EXPECT_EQ(found.records, count);
            EXPECT_NEAR(found.weight, weight, kRounding * (1.0f + weight));
            EXPECT_EQ(octree.serves(p, n, a), count > 0);
            served += count > 0 ? 1 : 0;
        }
    }
    EXPECT_GT(served, 1000);
}

// Whatever the order of insertion: a fixed point of R_i <= R_j + |p_i - p_j|.
TEST(WardOctree, NeighboursAreClamped) {
    Random random(4);
    WardOctree octree({.lower = vec3(-1), .upper = vec3(1)}, 0.5f);
    std::vector<float> given;
    for (int i = 0; i < 300; ++i) {
        const WardRecord record = randomRecord(random);
        given.push_back(record.radius);
        octree.insert(record, 0.0f);
    }
    const std::vector<WardRecord>& records = octree.records();
    int clamped = 0;
    for (size_t i = 0; i < records.size(); ++i) {
        EXPECT_LE(records[i].radius, given[i]);
        clamped += records[i].radius < given[i] ? 1 : 0;
        for (const WardRecord& other : records) {
            const float limit = other.radius + glm::length(records[i].position - other.position);
            EXPECT_LE(records[i].radius, limit * (1.0f + 1e-5f));
        }
    }
    EXPECT_GT(clamped, 50);
}

TEST(WardOctree, ClampingStopsAtTheLeastRadius) {
    WardOctree octree({.lower = vec3(-1), .upper = vec3(1)}, 0.5f);
    WardRecord record;
    record.normal = vec3(0, 1, 0);
    record.radius = 1.0f;
    octree.insert(record, 0.3f);
    record.radius = 1e-3f;
    octree.insert(record, 1e-3f);
    EXPECT_EQ(octree.records()[0].radius, 0.3f);
}

TEST(WardOctree, WhatLiesBeforeOrBehindIsNotServed) {
    WardRecord record;
    record.normal = vec3(0, 1, 0);
    record.radius = 1.0f;
    EXPECT_NEAR(wardError(record, vec3(0.3f, 0, 0), record.normal), 0.3f, 1e-6f);
    EXPECT_EQ(wardError(record, vec3(0.1f, 0.1f, 0), record.normal), kInfinity);
    EXPECT_EQ(wardError(record, vec3(0.1f, -0.1f, 0), record.normal), kInfinity);
    EXPECT_GE(wardError(record, record.position, -record.normal), 2.0f);
}

TEST(WardOctree, NoBoundsNoRecords) {
    WardOctree octree({}, 0.5f);
    EXPECT_EQ(octree.lookup(vec3(1), vec3(0, 1, 0), 0.5f).records, 0);
    WardRecord record;
    record.normal = vec3(0, 1, 0);
    record.radius = 0.1f;
    octree.insert(record, 0.1f);
    EXPECT_TRUE(octree.serves(vec3(0.0f), record.normal, 0.5f));
}

// A point that records disagree on is theirs by weight; a gradient is followed.
TEST(WardOctree, InterpolatesLinearLightExactly) {
    WardOctree octree({.lower = vec3(-1), .upper = vec3(1)}, 0.5f);
    const vec3 slope(0.5f, 0.0f, -0.25f);
    Random random(5);
    for (int i = 0; i < 20; ++i) {
        WardRecord r;
        r.position = vec3(random.uniform(-1, 1), 0, random.uniform(-1, 1));
        r.normal = vec3(0, 1, 0);
        r.radius = 4.0f;
        r.irradiance = vec3(2.0f + glm::dot(slope, r.position));
        r.translation = mat3(slope, slope, slope);
        octree.insert(r, 4.0f);
    }
    const vec3 p(0.2f, 0, -0.1f);
    EXPECT_NEAR(octree.lookup(p, vec3(0, 1, 0), 0.5f).irradiance.x, 2.0f + glm::dot(slope, p),
                1e-5f);
}

}  // namespace
}  // namespace sheen
