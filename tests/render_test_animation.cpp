// Sequences of frames: what is reused changes no bit.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/parallel.h"
#include "render/animation.h"
#include "test_render.h"

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
    AnimatedScene scene(sceneFile(name));
    FrameSequence sequence(scene, kParams, {});
    for (size_t i = 0; i < frames.size(); ++i) {
        const double seconds = frames[i] / 24.0;
        const RenderResult& result = sequence.render(frames[i]);
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
    FrameSequence sequence(scene, params, {});
    const Image<vec3> first = sequence.render(0).frame.indirect;
    EXPECT_FALSE(sameBits(sequence.render(1).frame.indirect, first));
    EXPECT_TRUE(sameBits(sequence.render(0).frame.indirect, first));
}

TEST(FrameSequence, APartOfTheImageIsThatOfThePart) {
    AnimatedScene scene(sceneFile("kite.glb"));
    FrameSequence sequence(scene, kParams, {.part = Crop{.first = {4, 5}, .size = {10, 8}}});
    const RenderResult& result = sequence.render(0);
    EXPECT_EQ(result.frame.width(), 10);
    EXPECT_EQ(result.frame.height(), 8);
}

// ---- Records that live on -----------------------------------------------------------------------

SequenceParams living(int longest) { return {.temporal = TemporalParams{.longest = longest}}; }

TEST(LivingRecords, ASceneThatStandsStillHasTheSameBits) {
    AnimatedScene scene(sceneFile("doors.glb"));
    FrameSequence sequence(scene, kParams, living(3));
    const RenderResult first = sequence.render(2);
    for (const int frame : {3, 4, 5, 6, 7, 8}) {
        EXPECT_TRUE(sameBits(sequence.render(frame).frame.indirect, first.frame.indirect));
        EXPECT_EQ(sequence.change(), SceneChange::kNothing);
    }
    EXPECT_TRUE(
        sameBits(first.frame.indirect,
                 renderFrame(sceneAt(sceneFile("doors.glb"), 2 / 24.0), kParams).frame.indirect))
        << "the first frame is as if rendered alone";
}

TEST(LivingRecords, FewerAreGatheredAndTheImageIsAsGood) {
    AnimatedScene scene(sceneFile("kite.glb"));
    FrameSequence sequence(scene, kParams, living(8));
    sequence.render(10);
    for (const int frame : {11, 12, 13, 14}) {
        const RenderResult& result = sequence.render(frame);
        const RenderStats& stats = result.stats;
        const RenderResult alone =
            renderFrame(sceneAt(sceneFile("kite.glb"), frame / 24.0), kParams);
        EXPECT_EQ(stats.pixels_uncovered, 0);
        EXPECT_EQ(stats.nonfinite_pixels, 0);
        EXPECT_LT(stats.records - stats.records_reused + stats.records_renewed,
                  alone.stats.records * 2 / 3)
            << frame;
        EXPECT_GT(stats.records_renewed, 0) << frame;
        EXPECT_LT(relativeRms(result.frame.indirect, alone.frame.indirect), 0.06) << frame;
    }
}

// Difference from the last frame rendered alone, of frames while the door opens.
double ghostOf(int longest) {
    AnimatedScene scene(sceneFile("doors.glb"));
    FrameSequence sequence(scene, kParams, living(longest));
    for (int frame = 16; frame < 20; ++frame) {
        sequence.render(frame);
    }
    const RenderResult alone = renderFrame(sceneAt(sceneFile("doors.glb"), 20 / 24.0), kParams);
    return relativeRms(sequence.render(20).frame.indirect, alone.frame.indirect);
}

TEST(LivingRecords, LightThatWasNotForeseenIsNoticed) {
    // It comes through the door; without witnesses the image would be wrong by half.
    EXPECT_LT(ghostOf(1), 0.05);
    EXPECT_LT(ghostOf(100), 0.1);
}

TEST(LivingRecords, ALifeOfOneFrameIsThatOfRecordsRenderedAnewInPlace) {
    AnimatedScene scene(sceneFile("kite.glb"));
    FrameSequence sequence(scene, kParams, living(1));
    sequence.render(10);
    const RenderStats& stats = sequence.render(11).stats;
    EXPECT_EQ(stats.records_renewed, stats.records_reused);
}

TEST(LivingRecords, ThoseOfFramesThatAreNotNeighboursAreNotMixed) {
    AnimatedScene scene(sceneFile("kite.glb"));
    FrameSequence sequence(scene, kParams, living(8));
    sequence.render(10);
    EXPECT_EQ(sequence.render(12).stats.records_reused, 0);
    EXPECT_GT(sequence.render(13).stats.records_reused, 0);
}

// ---- Interpolated: records are gathered ahead of images -----------------------------------------

SequenceParams onLines(int longest, int last, double fps = 24.0) {
    return {.fps = fps,
            .temporal =
                TemporalParams{.longest = longest, .gradients = TemporalGradients::kInterpolated},
            .last = last};
}

std::vector<RenderResult> framesOf(const char* name, const SequenceParams& sequence,
                                   const std::vector<int>& frames, RenderParams params = kParams) {
    AnimatedScene scene(sceneFile(name));
    params.all_layers = true;  // places among them
    FrameSequence rendered(scene, params, sequence);
    std::vector<RenderResult> results;
    for (const int frame : frames) {
        results.push_back(rendered.render(frame));
    }
    return results;
}

// The greatest change from frame to frame, over the pixel's light, of pixels that see what stands.
float greatestPop(const std::vector<RenderResult>& frames) {
    float pop = 0.0f;
    for (size_t i = 0; i < frames[0].frame.indirect.pixels.size(); ++i) {
        const bool stands = std::all_of(frames.begin(), frames.end(), [&](const auto& each) {
            return each.frame.primitive.pixels[i] == frames[0].frame.primitive.pixels[i] &&
                   each.frame.position.pixels[i] == frames[0].frame.position.pixels[i];
        });
        for (size_t n = 1; n < frames.size() && stands; ++n) {
            const vec3& before = frames[n - 1].frame.indirect.pixels[i];
            const vec3 change = frames[n].frame.indirect.pixels[i] - before;
            pop = std::max(pop, glm::length(change) / glm::length(before));
        }
    }
    return pop;
}

TEST(InterpolatedRecords, LightThatChangesSlowlyDoesNotPop) {
    // So slowly that a pixel's light changes by a fraction of a percent from frame to frame.
    constexpr double kFps = 480.0;
    const std::vector<int> frames = {300, 301, 302, 303, 304, 305};
    RenderParams params = kParams;
    params.gather.size = 32;
    params.placement.accuracy = 0.5f;
    EXPECT_LT(greatestPop(framesOf("kite.glb", onLines(4, 305, kFps), frames, params)), 0.01f);
    SequenceParams at_once = living(4);
    at_once.fps = kFps;
    EXPECT_GT(greatestPop(framesOf("kite.glb", at_once, frames, params)), 0.02f)
        << "the test finds pops";
}

TEST(InterpolatedRecords, TheImageIsAsGood) {
    const std::vector<RenderResult> frames =
        framesOf("kite.glb", onLines(8, 14), {10, 11, 12, 13, 14});
    for (int frame = 10; frame <= 14; ++frame) {
        const RenderResult& result = frames[static_cast<size_t>(frame - 10)];
        const RenderResult alone =
            renderFrame(sceneAt(sceneFile("kite.glb"), frame / 24.0), kParams);
        EXPECT_EQ(result.stats.pixels_uncovered, 0);
        EXPECT_EQ(result.stats.nonfinite_pixels, 0);
        EXPECT_LT(relativeRms(result.frame.indirect, alone.frame.indirect), 0.06) << frame;
    }
    EXPECT_GT(frames[2].stats.records_reused, frames[2].stats.records / 2);
}

TEST(InterpolatedRecords, LightThatComesSuddenlyDoesNotComeEarly) {
    // The door opens from frame 12 on.
    const std::vector<RenderResult> frames =
        framesOf("doors.glb", onLines(8, 17), {9, 10, 11, 12, 13, 14, 15, 16, 17});
    const Image<vec3>& at_rest = frames[0].frame.indirect;
    EXPECT_TRUE(sameBits(frames[2].frame.indirect, at_rest));
    const RenderResult alone = renderFrame(sceneAt(sceneFile("doors.glb"), 17 / 24.0), kParams);
    EXPECT_LT(relativeRms(frames[8].frame.indirect, alone.frame.indirect), 0.1);
}

TEST(InterpolatedRecords, FramesThatAreLeftOutChangeNoBit) {
    const auto all = framesOf("kite.glb", onLines(2, 14), {10, 11, 12, 13, 14});
    const auto some = framesOf("kite.glb", onLines(2, 14), {10, 12, 14});
    for (size_t k = 0; k < some.size(); ++k) {
        EXPECT_TRUE(sameBits(some[k].frame.indirect, all[2 * k].frame.indirect)) << k;
    }
}

TEST(InterpolatedRecords, ASceneThatStandsStillHasTheSameBits) {
    const auto frames = framesOf("doors.glb", onLines(3, 8), {2, 3, 5, 8});
    for (const RenderResult& each : frames) {
        EXPECT_TRUE(sameBits(each.frame.indirect, frames[0].frame.indirect));
    }
}

TEST(LivingRecords, OfAMovingCameraTheyDoNotAge) {
    AnimatedScene scene(sceneFile("orbit.glb"));
    FrameSequence sequence(scene, kParams, living(1));
    sequence.render(0);
    const RenderStats& stats = sequence.render(1).stats;
    EXPECT_EQ(sequence.change(), SceneChange::kCameras);
    EXPECT_GT(stats.records_reused, 0);
    EXPECT_EQ(stats.records_renewed, 0);
}

// ---- Records that are followed ------------------------------------------------------------------

const SequenceParams kByAnchors = {.anchors = true};

TEST(FollowedRecords, ASceneThatStandsStillHasTheSameBits) {
    const auto frames = framesOf("doors.glb", kByAnchors, {2, 3, 5, 8});
    for (const RenderResult& each : frames) {
        EXPECT_TRUE(sameBits(each.frame.indirect, frames[0].frame.indirect));
    }
}

TEST(FollowedRecords, FewerAreGatheredAndTheImageIsAsGood) {
    const auto frames = framesOf("kite.glb", kByAnchors, {10, 11, 12, 13, 14});
    for (int frame = 10; frame <= 14; ++frame) {
        const RenderResult& result = frames[static_cast<size_t>(frame - 10)];
        const RenderStats& stats = result.stats;
        const RenderResult alone =
            renderFrame(sceneAt(sceneFile("kite.glb"), frame / 24.0), kParams);
        EXPECT_EQ(stats.pixels_uncovered, 0);
        EXPECT_EQ(stats.nonfinite_pixels, 0);
        EXPECT_LT(relativeRms(result.frame.indirect, alone.frame.indirect), 0.06) << frame;
        if (frame > 10) {
            EXPECT_LT(stats.records - stats.records_reused + stats.records_renewed,
                      alone.stats.records * 2 / 3)
                << frame;
        }
    }
}

TEST(FollowedRecords, LightIsNotLate) {
    // The door opens from frame 12 on.
    const auto frames = framesOf("doors.glb", kByAnchors, {11, 12, 13, 14, 15, 16, 17, 18, 19, 20});
    const RenderResult alone = renderFrame(sceneAt(sceneFile("doors.glb"), 20 / 24.0), kParams);
    EXPECT_LT(relativeRms(frames.back().frame.indirect, alone.frame.indirect), 0.05);
    EXPECT_GT(relativeRms(frames.front().frame.indirect, alone.frame.indirect), 0.2);
    EXPECT_GT(frames.back().stats.records_reused, frames.back().stats.records / 2);
}

TEST(FollowedRecords, HaveTheSameBitsForAnyNumberOfThreads) {
    const int before = threadCount();
    setThreadCount(1);
    const auto alone = framesOf("kite.glb", kByAnchors, {20, 21, 22});
    setThreadCount(2);
    const auto together = framesOf("kite.glb", kByAnchors, {20, 21, 22});
    setThreadCount(before);
    for (size_t k = 0; k < alone.size(); ++k) {
        EXPECT_TRUE(sameBits(alone[k].frame.indirect, together[k].frame.indirect)) << k;
    }
}

TEST(FollowedRecords, OfAMovingCameraTheyStay) {
    const auto frames = framesOf("orbit.glb", kByAnchors, {0, 1});
    EXPECT_GT(frames[1].stats.records_reused, 0);
    EXPECT_EQ(frames[1].stats.records_renewed, 0);
}

// A record that lies at a pixel of this view, but not in its middle, may serve others alone.
TEST(LivingRecords, LeaveNoPixelBlackWhereTheCameraMoves) {
    AnimatedScene scene(sceneFile("orbit.glb"));
    RenderParams params;
    params.width = params.height = 64;
    params.bounces = 1;
    params.caustics = 0;
    params.aa = 1;
    params.all_layers = true;
    params.quiet = true;
    SequenceParams how;
    how.temporal = TemporalParams{};
    FrameSequence sequence(scene, params, how);
    for (int frame = 0; frame <= 2; ++frame) {
        const Frame& image = sequence.render(frame).frame;
        for (size_t i = 0; i < image.weight.pixels.size(); ++i) {
            EXPECT_GT(image.weight.pixels[i], 0.0f) << "frame " << frame << ", pixel " << i;
        }
    }
}

TEST(FollowedRecords, ThoseOfFramesThatAreNotNeighboursAreNotMixed) {
    const auto frames = framesOf("kite.glb", kByAnchors, {10, 12, 13});
    EXPECT_EQ(frames[1].stats.records_reused, 0);
    EXPECT_GT(frames[2].stats.records_reused, 0);
}

}  // namespace
}  // namespace sheen
