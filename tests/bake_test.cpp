// What is baked, against closed forms and the reference.
#include <gtest/gtest.h>

#include <cmath>

#include "bake/seams.h"
#include "core/parallel.h"
#include "metrics/compare.h"
#include "test_bake.h"

namespace sheen {
namespace {

// A floor of 2 x 2 about the origin.
Scene floorScene(float albedo = 0.5f) {
    Scene scene;
    const uint32_t white = addMaterial(scene, diffuseParams(vec3(albedo)));
    addQuad(scene, vec3(-1, 0, 1), vec3(2, 0, 0), vec3(0, 0, -2), white);
    return scene;
}

TEST(Bake, aPlaneUnderASunGetsItsIlluminanceTimesTheCosine) {
    Scene scene = floorScene();
    scene.lights.push_back(directionalLight(vec3(1, -1, 0), vec3(3, 2, 1)));
    const Bench bench(scene, 16);
    const Baked baked = bench.bake();
    int seen = 0;
    bench.forSeen([&](size_t i) {
        const vec3 expected = vec3(3, 2, 1) * std::sqrt(0.5f);
        EXPECT_LT(glm::length(baked.frame.direct.pixels[i] - expected), 1e-5f);
        EXPECT_EQ(baked.frame.indirect.pixels[i], vec3(0.0f));
        ++seen;
    });
    EXPECT_EQ(seen, 14 * 14);  // all but the padding
}

TEST(Bake, aPlaneUnderAPointLightFollowsTheInverseSquare) {
    Scene scene = floorScene();
    scene.lights.push_back(pointLight(vec3(0.2f, 1.5f, -0.1f), vec3(7.0f)));
    const Bench bench(scene, 16);
    const Baked baked = bench.bake();
    bench.forSeen([&](size_t i) {
        const vec3 way = vec3(0.2f, 1.5f, -0.1f) - bench.map.receivers.positions[i];
        const float d2 = glm::dot(way, way);
        const float expected = 7.0f * way.y / (d2 * std::sqrt(d2));
        EXPECT_NEAR(baked.frame.direct.pixels[i].x, expected, 1e-4f * expected);
    });
}

TEST(Bake, anEvenSkyGivesPiTimesItsRadiance) {
    Scene scene = floorScene();
    addSky(scene, vec3(0.5f, 1.0f, 2.0f));
    const Bench bench(scene, 16);
    for (const BakeMethod method : {BakeMethod::kRecords, BakeMethod::kTexels}) {
        const Baked baked = bench.bake({.method = method});
        EXPECT_EQ(baked.stats.uncovered, 0);
        bench.forSeen([&](size_t i) {
            const vec3 ratio = baked.frame.indirect.pixels[i] / (kPi * vec3(0.5f, 1.0f, 2.0f));
            EXPECT_LT(maxAbs(ratio - 1.0f), 0.002f);
        });
    }
}

// All walls shine and scatter half: radiance is 1 + 1/2 + 1/4 + ... = 2 everywhere.
TEST(Bake, aFurnaceAddsUpAllBounces) {
    Scene scene;
    const uint32_t glowing = addMaterial(scene, diffuseParams(vec3(0.5f), vec3(1.0f)));
    addBox(scene, vec3(0), vec3(1), glowing, true);
    const Bench bench(scene, 24);
    const Baked baked = bench.bake();
    double direct = 0.0, indirect = 0.0;
    int count = 0;
    bench.forSeen([&](size_t i) {
        direct += baked.frame.direct.pixels[i].x;
        indirect += baked.frame.indirect.pixels[i].x;
        ++count;
    });
    EXPECT_NEAR(direct / count, kPi, 0.01 * kPi);
    EXPECT_NEAR(indirect / count, kPi, 0.02 * kPi);
}

TEST(Bake, indirectOnlyLeavesOutWhatComesStraight) {
    Scene scene = cornellRoom(diffuseParams(vec3(0.5f)), diffuseParams(vec3(0.5f)));
    const Bench bench(scene, 32);
    const Baked all = bench.bake({.bounces = 1});
    const Baked indirect = bench.bake({.bounces = 1, .indirect_only = true});
    bench.forSeen([&](size_t i) {
        EXPECT_EQ(indirect.frame.direct.pixels[i], vec3(0.0f));
        EXPECT_EQ(indirect.frame.indirect.pixels[i], all.frame.indirect.pixels[i]);
    });
}

TEST(Bake, recordsAgreeWithPathTracedTexels) {
    const Scene scene = cornellRoom(diffuseParams(vec3(0.5f)), diffuseParams(vec3(0.5f)));
    const Bench bench(scene, 48);
    const Baked traced = bench.bake({.method = BakeMethod::kReference, .spp = 256});
    const Baked baked = bench.bake();
    EXPECT_EQ(baked.stats.uncovered, 0);
    const auto compare = [&](const Image<vec3>& test, const Image<vec3>& reference,
                             const Image<vec3>& variance) {
        return compareImages({.test = test,
                              .reference = reference,
                              .reference_variance = &variance,
                              .test_primitive = &baked.frame.primitive,
                              .reference_primitive = &traced.frame.primitive});
    };
    const Comparison indirect =
        compare(baked.frame.indirect, traced.frame.indirect, traced.frame.indirect_variance);
    EXPECT_LT(indirect.rel_rmse, 0.03);
    EXPECT_LT(std::abs(indirect.bias), 0.01);
    const Comparison direct =
        compare(baked.frame.direct, traced.frame.direct, traced.frame.direct_variance);
    EXPECT_LT(direct.rel_rmse, 1e-4);
    EXPECT_EQ(indirect.compared, bench.map.covered - bench.map.buried);
}

// Records know nothing of pages: surfaces have the same light, of as many records.
TEST(Bake, severalPagesHaveTheLightOfOne) {
    const Scene scene = cornellRoom(diffuseParams(vec3(0.5f)), diffuseParams(vec3(0.5f)));
    const auto sumsOf = [&](const Bench& bench, const Baked& baked) {
        const Image<vec3> light = beauty(baked.frame);
        std::vector<glm::dvec4> sums(scene.triangles.size());
        bench.forSeen([&](size_t i) {
            sums[bench.map.receivers.triangles[i]] += glm::dvec4(light.pixels[i], 1.0);
        });
        return sums;
    };
    const Bench one(scene, {.texels_per_metre = 20.0f});
    const Bench several(scene, {.size = 48, .texels_per_metre = 20.0f});
    ASSERT_EQ(one.map.atlas.pages, 1);
    ASSERT_GT(several.map.atlas.pages, 2);
    const Baked of_one = one.bake(), of_several = several.bake();
    EXPECT_EQ(of_several.stats.uncovered, 0);
    EXPECT_NEAR(of_several.stats.records, of_one.stats.records, 0.1 * of_one.stats.records);
    const auto a = sumsOf(one, of_one), b = sumsOf(several, of_several);
    constexpr size_t kOfWalls = 12;  // others are smaller than texels
    for (size_t t = 0; t < kOfWalls; ++t) {
        EXPECT_NEAR(a[t].w, b[t].w, 0.05 * a[t].w + 2.0);
        EXPECT_NEAR(a[t].y / a[t].w, b[t].y / b[t].w, 0.03 * a[t].y / a[t].w) << t;
    }
}

// A floor of two objects that touch, and one of two pieces that charts of their own cover.
TEST(Bake, lightGoesOnAcrossTheBordersOfCharts) {
    Scene scene;
    const uint32_t white = addMaterial(scene, diffuseParams(vec3(0.6f)));
    addQuad(scene, vec3(-1, 0, 1), vec3(1, 0, 0), vec3(0, 0, -2), white);
    addQuad(scene, vec3(0, 0, 1), vec3(1, 0, 0), vec3(0, 0, -2), white);
    addQuad(scene, vec3(-1, 0, -1), vec3(2, 0, 0), vec3(0, 1, 0), white);
    scene.second_uvs = {{0.02f, 0.02f}, {0.3f, 0.02f}, {0.3f, 0.6f},  {0.02f, 0.6f},
                        {0.4f, 0.02f},  {0.7f, 0.02f}, {0.7f, 0.6f},  {0.4f, 0.6f},
                        {0.02f, 0.7f},  {0.6f, 0.7f},  {0.6f, 0.98f}, {0.02f, 0.98f}};
    scene.lights.push_back(pointLight(vec3(0.3f, 0.8f, -0.4f), vec3(3.0f)));
    const Bench bench(scene, 64);
    EXPECT_TRUE(bench.map.atlas.of_file);
    const Seams seams = seamsOf(bench.map, bench.bake().frame.indirect);
    EXPECT_GT(seams.texels, 40);
    EXPECT_GT(seams.within, 0.0);
    EXPECT_LT(seams.across, 1.5 * seams.within);
    // What does not agree is found.
    Image<vec3> wrong(64, 64);
    bench.forSeen([&](size_t i) {
        wrong.pixels[i] = vec3(bench.map.receivers.triangles[i] < 2 ? 1.0f : 2.0f);
    });
    EXPECT_GT(seamsOf(bench.map, wrong).across, 0.5);
    EXPECT_EQ(seamsOf(bench.map, wrong).within, 0.0);
}

TEST(Bake, theNumberOfThreadsChangesNoBit) {
    const Scene scene = cornellRoom(diffuseParams(vec3(0.5f)), diffuseParams(vec3(0.5f)));
    const auto bakeBy = [&](int threads) {
        setThreadCount(threads);
        return Bench(scene, 32).bake();
    };
    const Baked one = bakeBy(1);
    const Baked four = bakeBy(4);
    setThreadCount(0);
    EXPECT_EQ(one.stats.records, four.stats.records);
    EXPECT_EQ(one.frame.direct.pixels, four.frame.direct.pixels);
    EXPECT_EQ(one.frame.indirect.pixels, four.frame.indirect.pixels);
}

}  // namespace
}  // namespace sheen
