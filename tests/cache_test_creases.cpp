// Creases, and the records that they get.
#include <gtest/gtest.h>

#include <algorithm>

#include "cache/creases.h"
#include "test_placement.h"

namespace sheen {
namespace {

constexpr int kEdge = kWidth / 2;

/// The floor with its right half higher by so many footprints, its wall not seen.
Stage steppedFloor(float footprints, float scale = 1.0f) {
    Stage stage = makeStage(0, 0, scale);
    GBuffer& g = stage.gbuffer;
    for (int y = 0; y < kHeight; ++y) {
        for (int x = kEdge; x < kWidth; ++x) {
            vec4& p = g.position.at(x, y);
            p.y += footprints * p.w * g.pixel_angle;
        }
    }
    return stage;
}

int count(const Image<uint8_t>& creases) {
    return static_cast<int>(std::count(creases.pixels.begin(), creases.pixels.end(), 1));
}

TEST(Creases, LieAtTheFootOfNarrowSteps) {
    for (float scale : {1e-3f, 1.0f, 1e4f}) {
        for (float footprints : {1.0f, 2.0f}) {
            const Stage stage = steppedFloor(footprints, scale);
            const Image<uint8_t> creases = findCreases(stage.gbuffer);
            for (int y = 0; y < kHeight; ++y) {
                for (int x = 0; x < kWidth; ++x) {
                    const bool foot = x == kEdge - 2 || x == kEdge - 1;
                    const bool seen = stage.gbuffer.seen(y * kWidth + x);
                    ASSERT_EQ(creases.at(x, y), foot && seen ? 1 : 0)
                        << x << ", " << y << " scale " << scale << " step " << footprints;
                }
            }
        }
    }
}

TEST(Creases, AreNeitherFlatFloorsNorHighStepsNorFarOnes) {
    EXPECT_EQ(count(findCreases(makeStage(0, 0).gbuffer)), 0);
    EXPECT_EQ(count(findCreases(steppedFloor(0.1f).gbuffer)), 0);
    EXPECT_EQ(count(findCreases(steppedFloor(4.5f).gbuffer)), 0);
    EXPECT_EQ(count(findCreases(GBuffer{})), 0);
}

TEST(Creases, AreNoCornersOfWalls) {
    Stage stage = makeStage(0, 0);
    GBuffer& g = stage.gbuffer;
    for (int y = 0; y < kHeight; ++y) {
        const vec4 foot = g.position.at(kEdge, y);
        for (int x = kEdge; x < kWidth; ++x) {
            const float up = (static_cast<float>(x - kEdge) + 0.5f) * foot.w * g.pixel_angle;
            g.position.at(x, y) = foot + vec4(0, up, 0, 0);
            g.normal.at(x, y) = vec4(-1, 0, 0, 1);
        }
    }
    EXPECT_EQ(count(findCreases(stage.gbuffer)), 0);
}

TEST(Creases, AreServedByRecordsThatReachNoFarther) {
    const Stage stage = steppedFloor(1.0f);
    const Image<uint8_t> creases = findCreases(stage.gbuffer);
    const PlacementParams params;
    const Placement placement = place(stage, params);
    expectCovered(stage, params, placement);
    ASSERT_GT(count(creases), 0);
    for (int i = 0; i < kWidth * kHeight; ++i) {
        if (creases.pixels[static_cast<size_t>(i)] == 0) {
            continue;
        }
        const vec4 p = stage.gbuffer.position.pixels[static_cast<size_t>(i)];
        const float footprint = p.w * stage.gbuffer.pixel_angle;
        bool near = false;
        for (const Record& r : placement.cache.records) {
            const float reach = params.servingWeight().accuracy * r.radius;
            near |= reach < 1.11f * params.min_pixels * footprint &&
                    glm::length(r.position - vec3(p)) < reach;
        }
        ASSERT_TRUE(near) << "pixel " << i;
    }
    // Elsewhere records reach as far as they did.
    EXPECT_LT(placement.cache.records.size(), place(makeStage(0, 0), params).cache.records.size() +
                                                  static_cast<size_t>(2 * count(creases)));
}

}  // namespace
}  // namespace sheen
