// Records gathered by rays: closed forms in box-shaped rooms, what their random places depend on,
// and how many rays they take for their reach.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>

#include "core/parallel.h"
#include "gather/ray_gather.h"
#include "test_light.h"
#include "test_scenes.h"
#include "test_sites.h"

namespace sheen {
namespace {

constexpr HemisphereParams kHemicube = {.kind = HemisphereKind::kHemicube, .size = 24};

// Of all classes and reaches.
std::vector<RecordSite> mixedSites(int count) {
    constexpr int kOrders[] = {shared::DIFFUSE_ORDER, 3, 6};
    constexpr float kReaches[] = {0.0f, 1.0f, 5.0f, 60.0f};
    std::vector<RecordSite> sites = sitesInGlossyRoom(count);
    for (size_t i = 0; i < sites.size(); ++i) {
        sites[i].order = kOrders[(i / 3) % 3];
        sites[i].reach = kReaches[i % 4];
    }
    return sites;
}

void expectSame(const std::vector<GatheredRecord>& a, const std::vector<GatheredRecord>& b) {
    ASSERT_EQ(a.size(), b.size());
    for (size_t i = 0; i < a.size(); ++i) {
        EXPECT_EQ(std::memcmp(&a[i].record, &b[i].record, sizeof(Record)), 0) << "record " << i;
        EXPECT_TRUE(a[i].sh == b[i].sh) << "record " << i;
        ASSERT_EQ(a[i].contrasts.size(), b[i].contrasts.size()) << "record " << i;
        for (size_t k = 0; k < a[i].contrasts.size(); ++k) {
            EXPECT_EQ(a[i].contrasts[k].position, b[i].contrasts[k].position);
            EXPECT_EQ(a[i].contrasts[k].strength, b[i].contrasts[k].strength);
        }
    }
}

// ---- The same records ---------------------------------------------------------------------------

TEST(RayGatherer, TheSameBitsForAnyThreads) {
    const Scene scene = glossyRoom();
    const LitByCells lit(scene);
    const std::vector<RecordSite> sites = mixedSites(18);
    setThreadCount(1);
    const std::vector<GatheredRecord> first = RayGatherer(lit.light, kHemicube).gather(sites);
    for (int threads : {1, 2, 3, 7}) {
        setThreadCount(threads);
        expectSame(RayGatherer(lit.light, kHemicube).gather(sites), first);
        // Embree's tree is built anew.
        const LitByCells other(scene);
        expectSame(RayGatherer(other.light, kHemicube).gather(sites), first);
    }
    setThreadCount(0);
}

TEST(RayGatherer, WhatWasGatheredBeforeDoesNotCount) {
    const Scene scene = glossyRoom();
    const LitByCells lit(scene);
    std::vector<RecordSite> sites = mixedSites(10);
    const std::vector<GatheredRecord> together = RayGatherer(lit.light, kHemicube).gather(sites);
    RayGatherer gatherer(lit.light, kHemicube);
    EXPECT_TRUE(gatherer.gather({}).empty());
    std::reverse(sites.begin(), sites.end());
    const std::span<const RecordSite> all(sites);
    std::vector<GatheredRecord> reversed = gatherer.gather(all.first(4));
    for (GatheredRecord& g : gatherer.gather(all.subspan(4))) {
        reversed.push_back(std::move(g));
    }
    std::reverse(reversed.begin(), reversed.end());
    expectSame(reversed, together);
}

TEST(RayGatherer, PlacesOfRaysDifferFromSeedToSeed) {
    // An edge of light crosses the hemisphere; the other channel is the same everywhere.
    Scene scene;
    const uint32_t dark = addMaterial(scene, diffuseParams(vec3(0.5f), vec3(0, 1, 0)));
    const uint32_t lamp = addMaterial(scene, diffuseParams(vec3(0.5f), vec3(1, 1, 0)));
    addBox(scene, vec3(-1), vec3(1), {dark, dark, dark, lamp, dark, dark}, true);
    const LitByCells lit(scene);
    const std::vector<RecordSite> sites = repeated(8, siteAt(vec3(0.1f, -1, 0.2f), vec3(0, 1, 0)));
    const std::vector<GatheredRecord> g = RayGatherer(lit.light, kHemicube).gather(sites);
    for (size_t i = 1; i < g.size(); ++i) {
        EXPECT_NE(g[i].record.irradiance.x, g[0].record.irradiance.x) << i;
        EXPECT_NEAR(g[i].record.irradiance.x, g[0].record.irradiance.x,
                    0.1f * g[0].record.irradiance.x);
        EXPECT_EQ(g[i].record.irradiance.y, g[0].record.irradiance.y);
    }
    EXPECT_NEAR(g[0].record.irradiance.y, kPi, 1e-4f);
    EXPECT_EQ(g[0].record.irradiance.z, 0.0f);
}

// ---- Closed forms -------------------------------------------------------------------------------

// A room whose faces emit light; its walls are perpendicular to the axes.
const vec3 kLower(-1.5f, -1.0f, -1.0f), kUpper(1.5f, 0.8f, 2.0f);
constexpr float kLamp = 2.0f;

// The corners of face (axis, side 0 or 1) of the room, in order around it.
std::array<vec3, 4> faceCorners(int axis, int side) {
    std::array<vec3, 4> corners;
    for (int i = 0; i < 4; ++i) {
        vec3& p = corners[static_cast<size_t>(i)];
        p[axis] = (side == 0 ? kLower : kUpper)[axis];
        const int u = (axis + 1) % 3, v = (axis + 2) % 3;
        p[u] = (i == 1 || i == 2 ? kUpper : kLower)[u];
        p[v] = (i >= 2 ? kUpper : kLower)[v];
    }
    return corners;
}

// Integral of dot(n, w) over the directions w from p to a polygon above p's horizon, where n may be
// any direction. (Lambert's formula.)
double cosineIntegral(const std::array<vec3, 4>& corners, const vec3& p, const vec3& n) {
    double sum = 0.0;
    for (size_t i = 0; i < 4; ++i) {
        const glm::dvec3 a = glm::normalize(glm::dvec3(corners[i] - p));
        const glm::dvec3 b = glm::normalize(glm::dvec3(corners[(i + 1) % 4] - p));
        const glm::dvec3 across = glm::cross(a, b);
        const double sine = glm::length(across);
        if (sine > 1e-12) {
            sum += 0.5 * std::atan2(sine, glm::dot(a, b)) * glm::dot(across, glm::dvec3(n)) / sine;
        }
    }
    return std::abs(sum);
}

// The room with one bright face.
Scene roomWithLamp(int axis, int side) {
    Scene scene;
    const uint32_t dark = addMaterial(scene, diffuseParams(vec3(0.5f)));
    const uint32_t lamp = addMaterial(scene, diffuseParams(vec3(0.5f), vec3(kLamp)));
    std::array<uint32_t, 6> materials;
    materials.fill(dark);
    materials[static_cast<size_t>(2 * axis + side)] = lamp;
    addBox(scene, kLower, kUpper, materials, true);
    return scene;
}

// Places are uniform over a texel's rectangle and weigh the same: a share that falls with the
// square of the texels' size, measured as 0.09% for the smallest light seen.
constexpr double kTexelBias = 1e-3;

// The mean of `value` over many records at one site is `expected` within three standard errors.
void expectMean(const Scene& scene, const RecordSite& site, double expected,
                const std::function<double(const GatheredRecord&)>& value) {
    constexpr int kRecords = 200;
    const LitByCells lit(scene);
    double sum = 0.0, squares = 0.0;
    for (const GatheredRecord& g :
         RayGatherer(lit.light, kHemicube).gather(repeated(kRecords, site))) {
        sum += value(g);
        squares += value(g) * value(g);
    }
    const double mean = sum / kRecords;
    const double variance = (squares / kRecords - mean * mean) / (kRecords - 1);
    const double error = std::sqrt(std::max(variance, 0.0));
    EXPECT_GT(error, 0.0);
    // Weak otherwise: a standard error is a few thousandths at most.
    EXPECT_LT(error, 5e-3 * expected);
    EXPECT_NEAR(mean, expected, 3.0 * error + kTexelBias * expected);
}

const RecordSite kFloorMiddle = siteAt(vec3(0, -1, 0.5f), vec3(0, 1, 0));
const RecordSite kFloorAside = siteAt(vec3(1.2f, -1, -0.7f), vec3(0, 1, 0));
const RecordSite kWall = siteAt(vec3(-1.5f, -0.2f, 0.5f), vec3(1, 0, 0));

TEST(RayGatherer, IrradianceOfABrightFaceIsUnbiased) {
    for (const RecordSite& site : {kFloorMiddle, kFloorAside, kWall}) {
        for (int face = 0; face < 6; ++face) {
            const std::array<vec3, 4> corners = faceCorners(face / 2, face % 2);
            const vec3 middle = 0.25f * (corners[0] + corners[1] + corners[2] + corners[3]);
            if (glm::dot(middle - site.position, site.normal) < 1e-3f) {
                continue;  // the site's own face
            }
            SCOPED_TRACE(face);
            expectMean(roomWithLamp(face / 2, face % 2), site,
                       kLamp * cosineIntegral(corners, site.position, site.normal),
                       [](const GatheredRecord& g) { return g.record.irradiance.y; });
        }
    }
}

TEST(RayGatherer, RadiusIsTheHarmonicMeanDistance) {
    for (const RecordSite& site : {kFloorMiddle, kFloorAside, kWall}) {
        // 1/distance is the cosine at a face over the distance to its plane.
        double sum = 0.0;
        for (int face = 0; face < 6; ++face) {
            const int axis = face / 2, side = face % 2;
            const float height =
                std::abs((side == 0 ? kLower : kUpper)[axis] - site.position[axis]);
            if (height > 0.0f) {
                vec3 toward(0.0f);
                toward[axis] = 1.0f;
                // What of the face is above the site's horizon is all of it.
                sum += cosineIntegral(faceCorners(axis, side), site.position, toward) / height;
            }
        }
        const Scene scene = roomWithLamp(0, 0);
        expectMean(scene, site, sum / (2.0 * kPi),
                   [](const GatheredRecord& g) { return 1.0 / g.record.radius; });
    }
}

TEST(RayGatherer, UniformLightGivesItsIrradianceAndHarmonics) {
    const vec3 Le(1.0f, 2.0f, 3.0f);
    Scene scene;
    addBox(scene, vec3(-1), vec3(1), addMaterial(scene, diffuseParams(vec3(0.5f), Le)), true);
    const LitByCells lit(scene);
    const std::vector<RecordSite> sites = {siteAt(vec3(0.3f, -1, 0.1f), vec3(0, 1, 0)),
                                           siteAt(vec3(0.3f, -1, 0.1f), vec3(0, 1, 0), 4)};
    const std::vector<GatheredRecord> g = RayGatherer(lit.light, kHemicube).gather(sites);
    EXPECT_TRUE(g[0].sh.empty());
    ASSERT_EQ(g[1].sh.size(), static_cast<size_t>(shLayout(4).size()));
    for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(g[0].record.irradiance[c], kPi * Le[c], 1e-4f * kPi * Le[c]);
        EXPECT_EQ(g[1].record.irradiance[c], g[0].record.irradiance[c]);
        // Straight up the series is near the radiance.
        const shared::ShVector y = shared::shBasis(vec3(0, 1, 0), 4);
        float radiance = 0.0f;
        for (int k = 0; k < 16; ++k) {
            radiance += g[1].sh[static_cast<size_t>(16 * c + k)] * y.c[k];
        }
        EXPECT_NEAR(radiance, Le[c], 0.1f * Le[c]);
    }
}

TEST(RayGatherer, NothingSeenIsDarkAndInfinitelyFar) {
    Scene scene;
    addQuad(scene, vec3(-1, 0, 1), vec3(2, 0, 0), vec3(0, 0, -2),
            addMaterial(scene, diffuseParams(vec3(0.5f), vec3(1.0f))));
    const LitByCells lit(scene);
    const RecordSite site = siteAt(vec3(0), vec3(0, 1, 0));
    const std::vector<GatheredRecord> g = RayGatherer(lit.light, kHemicube).gather({&site, 1});
    EXPECT_EQ(g[0].record.irradiance, vec3(0.0f));
    EXPECT_EQ(g[0].record.radius, kInfinity);
}

TEST(RayGatherer, ContrastsAnywhereDoNoHarm) {
    // Behind the record, at it, at the horizon, far away, on edges of the hemicube's faces.
    const Scene scene = roomWithLamp(1, 1);
    RecordSite site = kFloorMiddle;
    for (const vec3 offset : {vec3(0, -1, 0), vec3(0), vec3(1, 0, 0), vec3(1e20f, 1e20f, 0),
                              vec3(1, 1, 0), vec3(1, 1, 1), vec3(0, 1e-30f, 0)}) {
        site.contrasts.push_back({site.position + offset, 1e9f});
    }
    expectMean(scene, site, kLamp * cosineIntegral(faceCorners(1, 1), site.position, site.normal),
               [](const GatheredRecord& g) { return g.record.irradiance.y; });
}

// ---- More rays for records that reach farther ---------------------------------------------------

TEST(SideForReach, GrowsWithTheReachInEvenStepsWithinBounds) {
    EXPECT_EQ(sideForReach(100, 60.0f), 128);
    EXPECT_EQ(sideForReach(512, 60.0f), 512);
    for (int usual : {8, 18, 19, 38, 80}) {
        EXPECT_EQ(sideForReach(usual, 0.0f), usual);  // not known
        EXPECT_EQ(sideForReach(usual, 5.0f), usual);
        const int least = sideForReach(usual, 1.0f);
        const int most = sideForReach(usual, 30.0f);
        EXPECT_LT(least, usual);
        EXPECT_GT(most, usual);
        EXPECT_NEAR(least, 0.64 * usual, 1.0);
        EXPECT_NEAR(most, 1.5625 * usual, 1.0);
        EXPECT_EQ(sideForReach(usual, 1e-30f), least);
        EXPECT_EQ(sideForReach(usual, kInfinity), most);
        int before = 0;
        for (float reach = 0.5f; reach < 100.0f; reach *= 1.1f) {
            const int side = sideForReach(usual, reach);
            EXPECT_GE(side, before);
            EXPECT_TRUE(side == usual || side % 2 == 0) << side;
            before = side;
        }
    }
}

TEST(RayGatherer, RecordsThatReachFartherTakeMoreRaysAndErrLess) {
    const Scene scene = roomWithLamp(1, 1);
    const LitByCells lit(scene);
    constexpr int kRecords = 400;
    int64_t fewer = 0;
    double greater = kInfinity;
    for (float reach : {1.0f, 5.0f, 60.0f}) {
        // Anywhere: at one place the lamp's edge may happen to lie along those of texels.
        Random random(1);
        std::vector<RecordSite> sites;
        for (int i = 0; i < kRecords; ++i) {
            const vec3 p = random.point(-0.8f, 0.8f);
            sites.push_back(siteAt(vec3(p.x, kLower.y, p.z), vec3(0, 1, 0)));
            sites.back().reach = reach;
        }
        RayGatherer gatherer(lit.light, kHemicube);
        const std::vector<GatheredRecord> gathered = gatherer.gather(sites);
        double sum = 0.0, squares = 0.0;
        for (size_t i = 0; i < gathered.size(); ++i) {
            const double expected =
                kLamp * cosineIntegral(faceCorners(1, 1), sites[i].position, sites[i].normal);
            const double error = gathered[i].record.irradiance.y / expected - 1.0;
            sum += error;
            squares += error * error;
        }
        const double deviation = std::sqrt(squares / kRecords);
        const double texel = kHemicube.size / static_cast<double>(sideForReach(24, reach));
        EXPECT_NEAR(sum / kRecords, 0.0,
                    3.0 * deviation / std::sqrt(kRecords) + kTexelBias * texel * texel)
            << reach;
        EXPECT_GT(gatherer.rays(), fewer + fewer / 2) << reach;
        EXPECT_LT(deviation, 0.8 * greater) << reach;
        fewer = gatherer.rays();
        greater = deviation;
    }
}

}  // namespace
}  // namespace sheen
