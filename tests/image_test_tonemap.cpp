// The tone map against closed forms, automatic exposure, what a display shows.
#include <gtest/gtest.h>

#include <cmath>

#include "image/tonemap.h"
#include "image_test_colors.h"

namespace sheen {
namespace {

TEST(ToneMap, blackStaysBlack) {
    EXPECT_EQ(toneMap(vec3(0.0f)), vec3(0.0f));
    EXPECT_EQ(toneMap(vec3(-1.0f)), vec3(0.0f));
}

TEST(ToneMap, identityLessTheFresnelOffsetBelowTheShoulder) {
    // [KhronosNeutral]: c - 0.04 while all components are above 0.08 and the largest below 0.8.
    const vec3 mapped = toneMap(vec3(0.1f, 0.4f, 0.79f));
    EXPECT_NEAR(mapped.r, 0.06f, 1e-6f);
    EXPECT_NEAR(mapped.g, 0.36f, 1e-6f);
    EXPECT_NEAR(mapped.b, 0.75f, 1e-6f);
}

TEST(ToneMap, toeIsQuadratic) {
    // Grey below 0.08: x^2 / (4 * 0.04).
    EXPECT_NEAR(toneMap(vec3(0.04f)).r, 0.01f, 1e-7f);
}

TEST(ToneMap, shoulder) {
    // White 1: p = 0.96, p_n = 1 - 0.24^2 / 0.44; grey is not changed by the fade to white.
    EXPECT_NEAR(toneMap(vec3(1.0f)).g, 1.0f - 0.0576f / 0.44f, 1e-6f);
}

TEST(ToneMap, greyIsMonotoneAndBounded) {
    float previous = -1.0f;
    for (float x = 0.0f; x < 1e6f; x = x * 1.01f + 1e-4f) {
        const float y = toneMap(vec3(x)).r;
        ASSERT_GE(y, previous) << x;
        ASSERT_LE(y, 1.0f) << x;
        previous = y;
    }
    EXPECT_GT(previous, 0.999f);
}

TEST(ToneMap, staysInGamutAndBrightSaturatedColoursFadeToWhite) {
    for (float scale = 1e-3f; scale < 1e30f; scale *= 3.0f) {
        const vec3 y = toneMap(scale * vec3(1.0f, 0.2f, 0.0f));
        for (int c = 0; c < 3; ++c) {
            ASSERT_GE(y[c], 0.0f) << scale;
            ASSERT_LE(y[c], 1.0f) << scale;
        }
        ASSERT_GE(y.r, y.g);
        ASSERT_GE(y.g, y.b);
    }
    EXPECT_GT(toneMap(vec3(1e6f, 0.0f, 0.0f)).b, 0.99f);
}

TEST(ToneMap, srgb) {
    EXPECT_EQ(srgbFromLinear(0.0f), 0.0f);
    EXPECT_NEAR(srgbFromLinear(1.0f), 1.0f, 1e-6f);
    EXPECT_NEAR(srgbFromLinear(0.18f), 0.46136f, 1e-4f);
    EXPECT_NEAR(srgbFromLinear(0.0031308f), 0.04045f, 1e-5f);
}

TEST(AutoExposure, bringsTheLogAverageToMiddleGrey) {
    Image<vec3> image(2, 1, vec3(0.18f));
    EXPECT_NEAR(autoExposure(image), 0.0f, 1e-5f);
    image.at(0, 0) = vec3(0.36f);
    image.at(1, 0) = vec3(0.09f);
    EXPECT_NEAR(autoExposure(image), 0.0f, 1e-5f);
    image.at(1, 0) = vec3(0.36f);
    EXPECT_NEAR(autoExposure(image), -1.0f, 1e-5f);
}

TEST(AutoExposure, scalingIsUndone) {
    Image<vec3> image = colors(5, 4, 1.0f);
    const float stops = autoExposure(image);
    for (vec3& pixel : image.pixels) {
        pixel *= 1024.0f;
    }
    EXPECT_NEAR(autoExposure(image), stops - 10.0f, 1e-4f);
}

TEST(AutoExposure, ignoresBlackAndNonFinitePixels) {
    Image<vec3> image(4, 1, vec3(0.18f));
    image.at(1, 0) = vec3(0.0f);
    image.at(2, 0) = vec3(std::nanf(""));
    image.at(3, 0) = vec3(kInfinity);
    EXPECT_NEAR(autoExposure(image), 0.0f, 1e-5f);
    EXPECT_EQ(autoExposure(Image<vec3>(2, 2)), 0.0f);
    EXPECT_EQ(autoExposure(Image<vec3>()), 0.0f);
}

TEST(AutoExposure, deepShadowsDoNotBurnOutTheRest) {
    Image<vec3> image(2, 1, vec3(0.32f));
    image.at(1, 0) = vec3(1e-6f);  // counts as 0.16 / 16
    EXPECT_NEAR(autoExposure(image), std::log2(0.18f / std::sqrt(0.32f * 0.01f)), 1e-4f);
}

TEST(DisplayImage, exposureIsInStops) {
    const Image<vec3> image(1, 1, vec3(0.1f));
    const Image<vec3> twice(1, 1, vec3(0.2f));
    EXPECT_EQ(displayImage(image, 1.0f).at(0, 0).r, displayImage(twice, 0.0f).at(0, 0).r);
    EXPECT_GT(displayImage(image, 1.0f).at(0, 0).r, displayImage(image, 0.0f).at(0, 0).r);
}

TEST(DisplayImage, nonFinitePixelsAreMagenta) {
    const Image<vec3> image(1, 1, vec3(0.1f, std::nanf(""), 0.1f));
    const Rgb8 pixel = displayImage(image, 0.0f).at(0, 0);
    EXPECT_EQ(pixel.r, 255);
    EXPECT_EQ(pixel.g, 0);
    EXPECT_EQ(pixel.b, 255);
}

TEST(DisplayImage, extremeExposure) {
    const Image<vec3> image(1, 1, vec3(0.1f));
    EXPECT_EQ(displayImage(image, 1e9f).at(0, 0).g, 255);
    EXPECT_EQ(displayImage(image, -1e9f).at(0, 0).g, 0);
}

TEST(ToneMap, NoneClips) {
    EXPECT_EQ(toneMap(vec3(0.02f, 0.5f, 7.0f), ToneCurve::kNone), vec3(0.02f, 0.5f, 1.0f));
    EXPECT_EQ(toneMap(vec3(-1.0f, 1.0f, 0.0f), ToneCurve::kNone), vec3(0.0f, 1.0f, 0.0f));
    const Image<vec3> image(1, 1, vec3(2.0f, 0.5f, 0.0f));
    const Rgb8 pixel = displayImage(image, 0.0f, toSrgb(ToneCurve::kNone)).at(0, 0);
    EXPECT_EQ(pixel.r, 255);
    EXPECT_EQ(pixel.g, 188);  // sRGB of a half
    EXPECT_EQ(pixel.b, 0);
}

}  // namespace
}  // namespace sheen
