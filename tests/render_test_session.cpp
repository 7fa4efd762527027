// What sessions keep between frames, and frames between passes.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "core/error.h"
#include "core/timer.h"
#include "test_render.h"

namespace sheen {
namespace {

constexpr int kSize = 40;

void expectSame(const Image<vec3>& a, const Image<vec3>& b) {
    ASSERT_EQ(a.pixels.size(), b.pixels.size());
    EXPECT_EQ(std::memcmp(a.pixels.data(), b.pixels.data(), a.pixels.size() * sizeof(vec3)), 0);
}

TEST(Session, EveryFrameIsThatOfASessionOfItsOwn) {
    Scene scene = glossyRoom();
    scene.cameras.push_back(lookAt(vec3(-0.4f, 0.3f, 0.9f), vec3(0.3f, -0.7f, 0.0f)));
    Session session(scene);
    // Back to the first camera after the second, to the first road after the other, and a method
    // that keeps nothing in between.
    struct Step {
        const char* camera;
        GatherRoad road;
        Method method;
    };
    for (const Step& step : {Step{"0", GatherRoad::kRays, Method::kRadiance},
                             Step{"1", GatherRoad::kRays, Method::kRadiance},
                             Step{"1", GatherRoad::kRays, Method::kOctree},
                             Step{"0", GatherRoad::kRays, Method::kIrradiance},
                             Step{"0", GatherRoad::kRaster, Method::kRadiance},
                             Step{"1", GatherRoad::kRaster, Method::kRadiance},
                             Step{"0", GatherRoad::kRays, Method::kRadiance}}) {
        RenderParams params = smallRender(kSize, kSize, step.method, step.road);
        params.camera = step.camera;
        const RenderResult alone = renderFrame(scene, params);
        const RenderResult kept = session.render(params);
        expectSame(kept.frame.direct, alone.frame.direct);
        expectSame(kept.frame.indirect, alone.frame.indirect);
        EXPECT_EQ(kept.stats.records, alone.stats.records);
    }
}

TEST(Session, AFrameThatFailsLeavesItUsable) {
    const Scene scene = glossyRoom();
    Session session(scene);
    RenderParams params = smallRender(kSize, kSize);
    params.camera = "none of that name";
    EXPECT_THROW(session.render(params), Error);
    params.camera.clear();
    expectSame(session.render(params).frame.indirect, renderFrame(scene, params).frame.indirect);
}

// ---- Records that outlive frames ----------------------------------------------------------------

TEST(KeptRecordsOfASession, TheSameViewGathersNothingAndHasTheSameBits) {
    const Scene scene = glossyRoom();
    for (const int bounces : {1, kAllBounces}) {
        Session session(scene);
        session.keepRecords();
        RenderParams params = smallRender(kSize, kSize);
        params.bounces = bounces;
        const RenderResult first = session.render(params);
        EXPECT_EQ(first.stats.records_reused, 0);
        const RenderResult again = session.render(params);
        EXPECT_EQ(again.stats.records, first.stats.records);
        EXPECT_EQ(again.stats.records_reused, first.stats.records);
        expectSame(again.frame.indirect, first.frame.indirect);
        // The first frame of a session that keeps records is that of one that does not.
        expectSame(first.frame.indirect, renderFrame(scene, params).frame.indirect);
    }
}

TEST(KeptRecordsOfASession, AnotherViewGathersWhatIsMissingAlone) {
    Scene scene = glossyRoom();
    scene.cameras.push_back(lookAt(vec3(0.05f, 0.1f, 0.93f), vec3(-0.1f, -0.5f, -0.3f)));
    Session session(scene);
    session.keepRecords();
    RenderParams params = smallRender(kSize, kSize);
    session.render(params);
    params.camera = std::string("1");
    const RenderResult reused = session.render(params);
    const RenderResult alone = renderFrame(scene, params);
    const int gathered = reused.stats.records - reused.stats.records_reused;
    EXPECT_LT(gathered, alone.stats.records / 2);
    EXPECT_GT(gathered, 0);
    EXPECT_EQ(reused.stats.pixels_uncovered, 0);
    EXPECT_LT(relativeRms(reused.frame.indirect, alone.frame.indirect), 0.05);
    EXPECT_GE(static_cast<int>(session.records().size()), reused.stats.records);
}

TEST(KeptRecordsOfASession, WhatWasSeenLongestAgoIsDroppedFirst) {
    KeptRecords kept;
    for (int k = 0; k < 10; ++k) {
        RecordField field;
        field.records.resize(1);
        field.records[0].record.position.x = static_cast<float>(k);
        field.pixels = {0};
        kept.put(std::move(field));
    }
    kept.dropToLatest(20);
    EXPECT_EQ(kept.size(), 10u);
    kept.dropToLatest(3);
    ASSERT_EQ(kept.size(), 3u);
    for (int k = 0; k < 3; ++k) {
        EXPECT_EQ(kept.records()[static_cast<size_t>(k)].record.position.x,
                  static_cast<float>(7 + k));
    }
    kept.dropToLatest(0);
    EXPECT_EQ(kept.size(), 0u);
}

TEST(KeptRecordsOfASession, OtherOptionsBeginAnew) {
    const Scene scene = glossyRoom();
    Session session(scene);
    session.keepRecords();
    RenderParams params = smallRender(kSize, kSize);
    session.render(params);
    params.method = Method::kIrradiance;
    const RenderResult other = session.render(params);
    EXPECT_EQ(other.stats.records_reused, 0);
    expectSame(other.frame.indirect, renderFrame(scene, params).frame.indirect);
}

TEST(TimeLimit, EndsWithAWholeImage) {
    const Scene scene = glossyRoom();
    RenderParams params = smallRender(kSize, kSize);
    params.gather.size = 0;
    params.time_limit = 1e-6;
    const RenderResult first = renderFrame(scene, params);
    EXPECT_EQ(first.stats.passes, 1);
    EXPECT_EQ(first.stats.accuracy, 2.0f);
    EXPECT_EQ(first.stats.pixels_uncovered, 0);
    // However long this machine takes.
    params.time_limit = 20.0 * first.stats.seconds.placement + 20.0 * first.stats.seconds.gather;
    const RenderResult more = renderFrame(scene, params);
    EXPECT_EQ(more.stats.pixels_uncovered, 0);
    EXPECT_EQ(more.stats.nonfinite_pixels, 0);
    EXPECT_EQ(more.stats.accuracy<2.0f, more.stats.passes> 1);
}

}  // namespace
}  // namespace sheen
