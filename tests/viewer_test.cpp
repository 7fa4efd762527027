// What the window is made of, without a window: the camera in hand, the image on its thread.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <thread>

#include "core/error.h"
#include "test_render.h"
#include "viewer/camera_control.h"
#include "viewer/live_thread.h"

namespace sheen {
namespace {

void expectNear(const vec3& a, const vec3& b, float tolerance = 1e-5f) {
    EXPECT_LT(glm::length(a - b), tolerance)
        << a.x << " " << a.y << " " << a.z << ", " << b.x << " " << b.y << " " << b.z;
}

// ---- The camera ---------------------------------------------------------------------------------

CameraControl sampleControl() {
    return {lookAt(vec3(1.0f, 2.0f, 3.0f), vec3(0.0f)),
            {.lower = vec3(-1.0f), .upper = vec3(1.0f)}};
}

TEST(CameraControl, BeginsAsTheCameraItIsGiven) {
    const Camera start = lookAt(vec3(1.0f, 2.0f, 3.0f), vec3(0.2f, 0.1f, 0.0f));
    const CameraControl control(start, {.lower = vec3(-1.0f), .upper = vec3(1.0f)});
    for (int column = 0; column < 4; ++column) {
        expectNear(vec3(control.camera().world_from_camera[column]),
                   vec3(start.world_from_camera[column]));
    }
}

TEST(CameraControl, BecomesUprightAndSurvivesLookingStraightDown) {
    Camera down;
    down.world_from_camera =
        mat4(vec4(1, 0, 0, 0), vec4(0, 0, -1, 0), vec4(0, 1, 0, 0), vec4(0.0f, 5.0f, 0.0f, 1.0f));
    CameraControl control(down, {});
    control.orbit(0.3f, 0.0f);
    const mat4 m = control.camera().world_from_camera;
    EXPECT_NEAR(m[0].y, 0.0f, 1e-6f);
    EXPECT_LT(-m[2].y, -0.99f);  // still looks down
    for (int column = 0; column < 3; ++column) {
        EXPECT_NEAR(glm::length(vec3(m[column])), 1.0f, 1e-5f);
    }
}

TEST(CameraControl, OrbitsAboutItsTarget) {
    CameraControl control = sampleControl();
    const vec3 target = control.target();
    const float distance = glm::length(control.eye() - target);
    control.orbit(0.7f, -0.3f);
    expectNear(control.target(), target, 1e-4f);
    EXPECT_NEAR(glm::length(control.eye() - target), distance, 1e-4f);
    control.orbit(-0.7f, 0.0f);
    control.orbit(0.0f, 0.3f);
    expectNear(control.eye(), sampleControl().eye(), 1e-4f);
    // A whole turn, and never over the top.
    control.orbit(2.0f * kPi, 100.0f);
    EXPECT_GT(control.camera().world_from_camera[1].y, 0.0f);
}

TEST(CameraControl, TurnsAboutItsEyeAndMovesAlongTheImage) {
    CameraControl control = sampleControl();
    const vec3 eye = control.eye();
    control.turn(0.4f, 0.2f);
    expectNear(control.eye(), eye);
    const mat4 m = control.camera().world_from_camera;
    control.move({0.5f, -0.25f, 2.0f});
    expectNear(control.eye(), eye + vec3(m * vec4(0.5f, -0.25f, -2.0f, 0.0f)), 1e-5f);
}

TEST(CameraControl, ApproachesWithoutArriving) {
    CameraControl control = sampleControl();
    const vec3 target = control.target();
    control.approach(0.5f);
    EXPECT_NEAR(glm::length(control.eye() - target),
                0.5f * glm::length(sampleControl().eye() - target), 1e-4f);
    for (int i = 0; i < 1000; ++i) {
        control.approach(0.1f);
    }
    EXPECT_GT(glm::length(control.eye() - control.target()), 0.0f);
}

// ---- The image on its thread --------------------------------------------------------------------

constexpr int kSize = 24;

RenderParams liveParams() {
    RenderParams params = smallRender(kSize, kSize);
    params.all_layers = false;
    return params;
}

void waitUntilIdle(const LiveThread& live) {
    for (int i = 0; i < 12000 && !live.idle(); ++i) {
        std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    ASSERT_TRUE(live.idle());
}

TEST(LiveThread, ShowsTheCompleteImageAndFollowsItsSettings) {
    LiveThread live(std::make_unique<LiveImage>(glossyRoom(), liveParams()), 0.02);
    waitUntilIdle(live);
    const auto shown = live.shown();
    ASSERT_TRUE(shown);
    EXPECT_TRUE(shown->progress.complete);
    const Frame alone = renderFrame(glossyRoom(), liveParams()).frame;
    const Image<Rgb8> expected = displayImage(beauty(alone), std::nullopt);
    ASSERT_EQ(shown->pixels.pixels.size(), expected.pixels.size());
    double difference = 0.0;
    for (size_t i = 0; i < expected.pixels.size(); ++i) {
        difference += std::abs(shown->pixels.pixels[i].g - expected.pixels[i].g);
    }
    EXPECT_LT(difference / static_cast<double>(expected.pixels.size()), 5.0);  // of 255

    live.display({.exposure = -30.0f});
    waitUntilIdle(live);
    for (const Rgb8& pixel : live.shown()->pixels.pixels) {
        ASSERT_LT(pixel.g, 2);
    }
    for (const Channel channel :
         {Channel::kDirect, Channel::kIndirect, Channel::kAlbedo, Channel::kNormal, Channel::kDepth,
          Channel::kRoughness, Channel::kWeight, Channel::kOrder}) {
        live.display({.exposure = std::nullopt, .channel = channel, .marks = true});
        waitUntilIdle(live);
        EXPECT_EQ(live.shown()->pixels.pixels.size(), expected.pixels.size());
        EXPECT_FALSE(live.shown()->marks.empty());
    }
}

TEST(LiveThread, ChangesFadeInByBoundedSteps) {
    LiveThread live(std::make_unique<LiveImage>(glossyRoom(), liveParams()), 0.005);
    waitUntilIdle(live);
    live.display({.exposure = 0.0f, .tone = ToneCurve::kNone, .direct = 0.0f});
    waitUntilIdle(live);
    // Twice the light comes by steps of 15% of a pixel, or of the mean where that is brighter.
    auto before = live.shown();
    live.display({.exposure = 0.0f, .tone = ToneCurve::kNone, .direct = 0.0f, .indirect = 2.0f});
    int steps = 0;
    while (!live.idle()) {
        const auto now = live.shown();
        steps += now != before ? 1 : 0;
        before = now;
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
    EXPECT_GE(steps, 4);  // 1.15^5 = 2.01; the last may be missed here
}

TEST(LiveThread, JobsThatReplaceEachOtherRunOnceAndErrorsAreKept) {
    LiveThread live(std::make_unique<LiveImage>(glossyRoom(), liveParams()), 0.02);
    std::atomic<int> runs{0}, last{0};
    // Keeps the thread busy, so that the others wait.
    live.post([](LiveImage&) { std::this_thread::sleep_for(std::chrono::milliseconds(300)); });
    std::this_thread::sleep_for(std::chrono::milliseconds(100));
    for (int i = 1; i <= 50; ++i) {
        live.post(
            [&runs, &last, i](LiveImage&) {
                ++runs;
                last = i;
            },
            kLightsJob);
    }
    live.post([](LiveImage&) { throwInput("scene.glb: a broken thing; mend it"); });
    waitUntilIdle(live);
    EXPECT_EQ(last, 50);
    EXPECT_LT(runs, 50);
    const std::optional<Failure> failure = live.failure();
    ASSERT_TRUE(failure);
    EXPECT_EQ(failure->message, "scene.glb: a broken thing; mend it");
    EXPECT_EQ(failure->code, ExitCode::kInput);
    EXPECT_FALSE(live.failure());
    EXPECT_TRUE(live.shown()->progress.complete);  // and goes on
}

}  // namespace
}  // namespace sheen
