// Sequences of frames: what is reused changes no bit.
#include <gtest/gtest.h>

#include <cstring>

#include "render/animation.h"

namespace sheen {
namespace {

bool sameBits(const Image<vec3>& a, const Image<vec3>& b) {
    return a.pixels.size() == b.pixels.size() &&
           std::memcmp(a.pixels.data(), b.pixels.data(), a.pixels.size() * sizeof(vec3)) == 0;
}

const RenderParams kParams = [] {
    RenderParams params;
    params.width = params.height = 24;
    params.bounces = 1;
    params.caustics = 0;
    params.gather.size = 16;
    params.placement.accuracy = 1.0f;
    params.quiet = true;
    return params;
}();

std::string sceneFile(const char* name) { return std::string(SHEEN_SCENES) + "/" + name; }

// Every frame of a sequence is that of a scene loaded at its time and rendered alone.
void expectFramesAsAlone(const char* name, const std::vector<int>& frames,
                         const std::vector<SceneChange>& changes) {
    constexpr double kFps = 24.0;
    AnimatedScene scene(sceneFile(name));
    FrameSequence sequence(scene, kParams);
    for (size_t i = 0; i < frames.size(); ++i) {
        const double seconds = frames[i] / kFps;
        const RenderResult& result = sequence.render(frames[i], seconds);
        EXPECT_EQ(sequence.change(), changes[i]) << name << ", frame " << frames[i];
        const RenderResult alone = renderFrame(sceneAt(sceneFile(name), seconds), kParams);
        EXPECT_TRUE(sameBits(result.frame.indirect, alone.frame.indirect))
            << name << ", frame " << frames[i];
        EXPECT_TRUE(sameBits(result.frame.direct, alone.frame.direct));
        EXPECT_EQ(result.stats.records, alone.stats.records);
        EXPECT_EQ(result.stats.nonfinite_pixels, 0);
    }
}

TEST(FrameSequence, FramesOfAMovingDoorAreAsRenderedAlone) {
    // It stands until frame 12.
    expectFramesAsAlone("doors.glb", {3, 7, 20},
                        {SceneChange::kScene, SceneChange::kNothing, SceneChange::kScene});
}

TEST(FrameSequence, FramesOfAMovingObjectAreAsRenderedAlone) {
    expectFramesAsAlone("kite.glb", {10, 11}, {SceneChange::kScene, SceneChange::kScene});
}

TEST(FrameSequence, FramesOfAMovingCameraAreAsRenderedAlone) {
    expectFramesAsAlone("orbit.glb", {0, 30}, {SceneChange::kScene, SceneChange::kCameras});
}

TEST(FrameSequence, PathTracersDrawAnewInEveryFrame) {
    AnimatedScene scene(sceneFile("cornell_diffuse.glb"));
    RenderParams params = kParams;
    params.method = Method::kReference;
    params.spp = 4;
    FrameSequence sequence(scene, params);
    const Image<vec3> first = sequence.render(0, 0.0).frame.indirect;
    EXPECT_FALSE(sameBits(sequence.render(1, 1.0).frame.indirect, first));
    EXPECT_TRUE(sameBits(sequence.render(0, 0.0).frame.indirect, first));
}

TEST(FrameSequence, APartOfTheImageIsThatOfThePart) {
    AnimatedScene scene(sceneFile("kite.glb"));
    FrameSequence sequence(scene, kParams, Crop{.first = {4, 5}, .size = {10, 8}});
    const RenderResult& result = sequence.render(0, 0.0);
    EXPECT_EQ(result.frame.width(), 10);
    EXPECT_EQ(result.frame.height(), 8);
}

}  // namespace
}  // namespace sheen
