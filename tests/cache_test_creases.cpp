// Creases, and the records that they get.
#include <gtest/gtest.h>

#include <algorithm>

#include "receivers/creases.h"
#include "test_placement.h"

namespace sheen {
namespace {

constexpr int kEdge = kWidth / 2;

/// The floor with its right half higher by so many footprints, its wall not seen.
Stage steppedFloor(float footprints, float scale = 1.0f) {
    Stage stage = makeStage(0, 0, scale);
    Receivers& r = stage.receivers;
    for (int y = 0; y < kHeight; ++y) {
        for (int x = kEdge; x < kWidth; ++x) {
            const size_t i = r.image.index(x, y);
            r.positions[i].y += footprints * r.footprints[i];
        }
    }
    return stage;
}

int count(const std::vector<uint8_t>& creases) {
    return static_cast<int>(std::count(creases.begin(), creases.end(), 1));
}

TEST(Creases, LieAtTheFootOfNarrowSteps) {
    for (float scale : {1e-3f, 1.0f, 1e4f}) {
        for (float footprints : {1.0f, 2.0f}) {
            const Stage stage = steppedFloor(footprints, scale);
            const std::vector<uint8_t> creases = findCreases(stage.receivers);
            for (int y = 0; y < kHeight; ++y) {
                for (int x = 0; x < kWidth; ++x) {
                    const bool foot = x == kEdge - 2 || x == kEdge - 1;
                    const size_t i = stage.receivers.image.index(x, y);
                    ASSERT_EQ(creases[i], foot && stage.receivers.seen(i) ? 1 : 0)
                        << x << ", " << y << " scale " << scale << " step " << footprints;
                }
            }
        }
    }
}

TEST(Creases, AreNeitherFlatFloorsNorHighStepsNorFarOnes) {
    EXPECT_EQ(count(findCreases(makeStage(0, 0).receivers)), 0);
    EXPECT_EQ(count(findCreases(steppedFloor(0.1f).receivers)), 0);
    EXPECT_EQ(count(findCreases(steppedFloor(4.5f).receivers)), 0);
    EXPECT_EQ(count(findCreases(Receivers{})), 0);
}

TEST(Creases, AreNoCornersOfWalls) {
    Stage stage = makeStage(0, 0);
    Receivers& r = stage.receivers;
    for (int y = 0; y < kHeight; ++y) {
        const size_t foot = r.image.index(kEdge, y);
        const vec3 position = r.positions[foot];
        for (int x = kEdge; x < kWidth; ++x) {
            const size_t i = r.image.index(x, y);
            const float up = (static_cast<float>(x - kEdge) + 0.5f) * r.footprints[foot];
            r.positions[i] = position + vec3(0, up, 0);
            r.footprints[i] = r.footprints[foot];
            r.normals[i] = vec3(-1, 0, 0);
        }
    }
    EXPECT_EQ(count(findCreases(stage.receivers)), 0);
}

TEST(Creases, AreServedByRecordsThatReachNoFarther) {
    const Stage stage = steppedFloor(1.0f);
    const std::vector<uint8_t> creases = findCreases(stage.receivers);
    const PlacementParams params;
    const Placement placement = place(stage, params);
    expectCovered(stage, params, placement);
    ASSERT_GT(count(creases), 0);
    for (size_t i = 0; i < creases.size(); ++i) {
        if (creases[i] == 0) {
            continue;
        }
        const float footprint = stage.receivers.footprints[i];
        bool near = false;
        for (const Record& r : placement.cache.records) {
            const float reach = params.servingWeight().accuracy * r.radius;
            near |= reach < 1.11f * params.min_pixels * footprint &&
                    glm::length(r.position - stage.receivers.positions[i]) < reach;
        }
        ASSERT_TRUE(near) << "pixel " << i;
    }
    // Elsewhere records reach as far as they did.
    EXPECT_LT(placement.cache.records.size(), place(makeStage(0, 0), params).cache.records.size() +
                                                  static_cast<size_t>(2 * count(creases)));
}

}  // namespace
}  // namespace sheen
