// Flicker against values computed by hand.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/error.h"
#include "image/frame.h"
#include "metrics/flicker.h"

namespace sheen {
namespace {

constexpr double kFlickerRounding = 1e-6;

Image<vec3> flat(float value, int side = 4) { return Image<vec3>(side, side, vec3(value)); }

TEST(Flicker, ASequenceDoesNotFlickerAgainstItself) {
    FlickerMeter meter;
    for (int frame = 0; frame < 4; ++frame) {
        const Image<vec3> image = flat(1.0f + 0.5f * static_cast<float>(frame));
        meter.add(frame, {.test = image, .reference = image});
    }
    ASSERT_TRUE(meter.result());
    EXPECT_EQ(meter.result()->value, 0.0);
    EXPECT_EQ(meter.result()->resolution, 0.0);
    EXPECT_EQ(meter.result()->pairs, 3);
}

TEST(Flicker, AnErrorThatStaysDoesNotFlicker) {
    FlickerMeter meter;
    for (int frame = 0; frame < 3; ++frame) {
        const Image<vec3> reference = flat(1.0f + static_cast<float>(frame));
        const Image<vec3> test = flat(1.25f + static_cast<float>(frame));
        meter.add(frame, {.test = test, .reference = reference});
    }
    EXPECT_EQ(meter.result()->value, 0.0);
}

TEST(Flicker, AnErrorThatChangesItsSignFlickersTwice) {
    FlickerMeter meter;
    for (int frame = 0; frame < 5; ++frame) {
        const Image<vec3> test = flat(2.0f + (frame % 2 == 0 ? 0.25f : -0.25f));
        meter.add(frame, {.test = test, .reference = flat(2.0f)});
    }
    EXPECT_NEAR(meter.result()->value, 0.5 / 2.0, kFlickerRounding);
}

TEST(Flicker, ItsMeanIsOverPixelsChannelsAndPairs) {
    // One channel of one of 16 pixels jumps by 1 in one of two pairs; the mean is that of all.
    FlickerMeter meter;
    const Image<vec3> reference = flat(4.0f);
    Image<vec3> jumped = reference;
    jumped.at(1, 2).y += 1.0f;
    meter.add(0, {.test = reference, .reference = reference});
    meter.add(1, {.test = jumped, .reference = reference});
    meter.add(2, {.test = jumped, .reference = reference});
    EXPECT_NEAR(meter.result()->value, std::sqrt(1.0 / (2 * 16 * 3)) / 4.0, kFlickerRounding);
}

TEST(Flicker, TheReferencesNoiseIsTakenOff) {
    // A test that stands still and a noisy reference of deviation s: nothing is left, within what
    // the noise hides, while without the variance sqrt(2) s would be.
    constexpr float kDeviation = 0.1f;
    std::mt19937 random(7);
    std::normal_distribution<float> normal(0.0f, kDeviation);
    const int side = 64;
    const Image<vec3> variance = flat(kDeviation * kDeviation, side);
    FlickerMeter meter, blind;
    for (int frame = 0; frame < 6; ++frame) {
        Image<vec3> reference = flat(1.0f, side);
        for (vec3& pixel : reference.pixels) {
            pixel += vec3(normal(random), normal(random), normal(random));
        }
        const Image<vec3> test = flat(1.0f, side);
        meter.add(frame, {.test = test, .reference = reference, .reference_variance = &variance});
        blind.add(frame, {.test = test, .reference = reference});
    }
    EXPECT_NEAR(blind.result()->value, std::sqrt(2.0) * kDeviation, 0.002);
    // sqrt(sqrt(2 V^2 / N)) of V = 2 s^2, N = 5 * 64 * 64 * 3, and what is left of the mean.
    const double expected =
        std::pow(2.0 / (5 * side * side * 3), 0.25) * std::sqrt(2.0) * kDeviation;
    EXPECT_NEAR(meter.result()->resolution, expected, 0.2 * expected);
    EXPECT_LT(meter.result()->value, 2.0 * meter.result()->resolution);
    EXPECT_NEAR(meter.result()->noise_share, 1.0, 0.05);
}

TEST(Flicker, FlickerShowsThroughTheReferencesNoise) {
    constexpr float kDeviation = 0.1f, kJump = 0.05f;
    std::mt19937 random(3);
    std::normal_distribution<float> normal(0.0f, kDeviation);
    const int side = 64;
    const Image<vec3> variance = flat(kDeviation * kDeviation, side);
    FlickerMeter meter;
    for (int frame = 0; frame < 9; ++frame) {
        Image<vec3> reference = flat(1.0f, side);
        for (vec3& pixel : reference.pixels) {
            pixel += vec3(normal(random), normal(random), normal(random));
        }
        const Image<vec3> test = flat(1.0f + (frame % 2 == 0 ? kJump : -kJump), side);
        meter.add(frame, {.test = test, .reference = reference, .reference_variance = &variance});
    }
    const Flicker flicker = *meter.result();
    EXPECT_NEAR(flicker.value * flicker.value, 4.0 * kJump * kJump,
                4.0 * flicker.resolution * flicker.resolution);
}

TEST(Flicker, NoiseThatIsTheSameInBothChangesNothing) {
    // Two references of one seed, of a scene that stands still.
    const Image<vec3> variance = flat(0.04f);
    FlickerMeter meter;
    for (int frame = 0; frame < 2; ++frame) {
        const Image<vec3> test = flat(1.0f + 0.1f * static_cast<float>(frame));
        meter.add(frame, {.test = test, .reference = flat(1.0f), .reference_variance = &variance});
    }
    EXPECT_NEAR(meter.result()->value, 0.1, kFlickerRounding);
}

TEST(Flicker, OnlyNeighboursMakePairs) {
    FlickerMeter meter;
    for (const int frame : {0, 2, 4}) {
        const Image<vec3> image = flat(static_cast<float>(frame));
        meter.add(frame, {.test = image, .reference = flat(1.0f)});
    }
    EXPECT_FALSE(meter.result());
    const Image<vec3> image = flat(5.0f);
    meter.add(5, {.test = image, .reference = flat(1.0f)});
    ASSERT_TRUE(meter.result());
    EXPECT_EQ(meter.result()->pairs, 1);
    EXPECT_NEAR(meter.result()->value, 1.0, kFlickerRounding);
}

TEST(Flicker, PixelsThatSeeSomethingElseDoNotCount) {
    FlickerMeter meter;
    const Image<vec3> reference = flat(1.0f);
    Image<uint32_t> triangles(4, 4, 0u);
    triangles.at(3, 3) = kNoPrimitive;
    Image<uint32_t> others = triangles;
    others.at(0, 0) = 9;
    Image<vec3> test = reference;
    for (int frame = 0; frame < 2; ++frame) {
        test.at(0, 0) = vec3(static_cast<float>(100 * frame));  // sees another triangle
        test.at(3, 3) = vec3(static_cast<float>(50 * frame));   // sees nothing
        test.at(1, 1) = vec3(1.0f + static_cast<float>(frame));
        meter.add(frame, {.test = test,
                          .reference = reference,
                          .test_primitive = &others,
                          .reference_primitive = &triangles});
    }
    EXPECT_NEAR(meter.result()->value, std::sqrt(1.0 / 14.0), kFlickerRounding);
}

TEST(Flicker, ABlackReferenceHasNoRelativeFlicker) {
    FlickerMeter still, moving;
    for (int frame = 0; frame < 2; ++frame) {
        still.add(frame, {.test = flat(1.0f), .reference = flat(0.0f)});
        moving.add(frame, {.test = flat(static_cast<float>(frame)), .reference = flat(0.0f)});
    }
    EXPECT_EQ(still.result()->value, 0.0);
    EXPECT_TRUE(std::isinf(moving.result()->value));
}

TEST(Flicker, FramesOfOtherSizesAreRefused) {
    FlickerMeter meter;
    meter.add(0, {.test = flat(1.0f), .reference = flat(1.0f)});
    EXPECT_THROW(meter.add(1, {.test = flat(1.0f, 5), .reference = flat(1.0f, 5)}), Error);
}

}  // namespace
}  // namespace sheen
