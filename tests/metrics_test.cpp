// Every metric against a value computed by hand.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "image/frame.h"
#include "metrics/compare.h"

namespace sheen {
namespace {

// Float images, doubles inside: sums of few small numbers.
constexpr double kRounding = 1e-6;

// Two pixels; the reference is 1 and 3 (mean 2) in all channels.
Image<vec3> twoPixels(float left, float right) {
    Image<vec3> image(2, 1);
    image.at(0, 0) = vec3(left);
    image.at(1, 0) = vec3(right);
    return image;
}

TEST(Compare, IdenticalImagesHaveNoError) {
    const Image<vec3> image = twoPixels(1.0f, 3.0f);
    const Image<vec3> variance = twoPixels(0.1f, 0.1f);
    const Comparison c =
        compareImages({.test = image, .reference = image, .reference_variance = &variance});
    EXPECT_EQ(c.rel_rmse, 0.0);
    EXPECT_EQ(c.rel_mse, 0.0);
    EXPECT_EQ(c.bias, 0.0);
    EXPECT_EQ(c.median, 0.0);
    EXPECT_EQ(c.p99, 0.0);
    EXPECT_EQ(c.max, 0.0);
    EXPECT_EQ(c.tile_max, 0.0);
    EXPECT_EQ(c.noise_share, 0.0);
    EXPECT_EQ(c.compared, 2);
    EXPECT_TRUE(c.judged);
}

TEST(Compare, RmseIsRelativeToTheReferencesMean) {
    const Image<vec3> reference = twoPixels(1.0f, 3.0f), test = twoPixels(1.5f, 3.0f);
    const Comparison c = compareImages({.test = test, .reference = reference});
    // mean squared error 0.25 / 2, over a mean of 2
    EXPECT_NEAR(c.rel_rmse, std::sqrt(0.125) / 2.0, kRounding);
    EXPECT_NEAR(c.rel_mse, 0.125 / 4.0, kRounding);
}

TEST(Compare, ChannelsAreSamples) {
    const Image<vec3> reference(1, 1, vec3(1.0f));
    const Image<vec3> test(1, 1, vec3(1.0f, 1.3f, 1.0f));
    const Comparison c = compareImages({.test = test, .reference = reference});
    EXPECT_NEAR(c.rel_mse, 0.09 / 3.0, kRounding);
    EXPECT_NEAR(c.bias, 0.1, kRounding);
}

TEST(Compare, BiasKeepsItsSign) {
    const Image<vec3> reference = twoPixels(1.0f, 3.0f);
    const Image<vec3> darker = twoPixels(1.5f, 1.5f), balanced = twoPixels(2.0f, 2.0f);
    EXPECT_NEAR(compareImages({.test = darker, .reference = reference}).bias, -0.5 / 2.0,
                kRounding);
    EXPECT_NEAR(compareImages({.test = balanced, .reference = reference}).bias, 0.0, kRounding);
}

TEST(Compare, QuantilesOfTheRelativeError) {
    // 200 pixels of 1; errors 0.001 * i in every channel. Mean 1: the floor adds 0.01.
    Image<vec3> reference(200, 1, vec3(1.0f)), test = reference;
    for (int i = 0; i < 200; ++i) {
        test.at(i, 0) += vec3(0.001f * static_cast<float>(i) * (i % 2 == 0 ? 1.0f : -1.0f));
    }
    const Comparison c = compareImages({.test = test, .reference = reference});
    EXPECT_NEAR(c.median, 0.099 / 1.01, kRounding);  // the 300th of 600 samples
    EXPECT_NEAR(c.p99, 0.197 / 1.01, kRounding);     // the 594th
    EXPECT_NEAR(c.max, 0.199 / 1.01, kRounding);
}

TEST(Compare, DarkPixelsDivideByTheFloor) {
    const Image<vec3> reference = twoPixels(0.0f, 2.0f), test = twoPixels(0.005f, 2.0f);
    EXPECT_NEAR(compareImages({.test = test, .reference = reference}).max, 0.005 / 0.01, 1e-5);
}

TEST(Compare, WorstTile) {
    Image<vec3> reference(48, 32, vec3(1.0f)), test = reference;
    for (int y = 16; y < 32; ++y) {
        for (int x = 16; x < 32; ++x) {
            test.at(x, y) = vec3(1.2f);
        }
    }
    test.at(0, 0) = vec3(2.0f);  // alone in its tile: RMSE 1/16
    const Comparison c = compareImages({.test = test, .reference = reference});
    EXPECT_NEAR(c.tile_max, 0.2 / 1.05, kRounding);
    EXPECT_EQ(c.worst_tile, ivec2(16, 16));
}

TEST(Compare, TileCutByTheImagesEdge) {
    // The last column of 17 is a tile of its own, 1 x 10 pixels, half of them off by 0.3.
    Image<vec3> reference(17, 10, vec3(2.0f)), test = reference;
    for (int y = 0; y < 5; ++y) {
        test.at(16, y) -= vec3(0.3f);
    }
    const Comparison c = compareImages({.test = test, .reference = reference});
    EXPECT_NEAR(c.tile_max, std::sqrt(0.045) / 2.1, kRounding);
    EXPECT_EQ(c.worst_tile, ivec2(16, 0));
}

TEST(Compare, TheReferencesNoiseIsSubtracted) {
    const Image<vec3> reference = twoPixels(1.0f, 3.0f), test = twoPixels(1.5f, 2.5f);
    const Image<vec3> variance = twoPixels(0.02f, 0.08f);
    const Comparison c =
        compareImages({.test = test, .reference = reference, .reference_variance = &variance});
    EXPECT_NEAR(c.noise_share, 0.05 / 0.25, kRounding);
    EXPECT_NEAR(c.rel_mse, 0.20 / 4.0, kRounding);
    EXPECT_NEAR(c.rel_rmse, std::sqrt(0.20) / 2.0, kRounding);
    EXPECT_NEAR(c.tile_max, std::sqrt(0.20) / 2.1, kRounding);
    EXPECT_NEAR(c.median, 0.5 / 3.02, kRounding);  // as they are
    EXPECT_TRUE(c.judged);
}

TEST(Compare, RefusesToJudgeByANoisyReference) {
    const Image<vec3> reference = twoPixels(1.0f, 3.0f), test = twoPixels(1.5f, 2.5f);
    const Image<vec3> half = twoPixels(0.125f, 0.125f), more = twoPixels(0.126f, 0.126f),
                      all = twoPixels(1.0f, 1.0f);
    const auto compare = [&](const Image<vec3>& variance) {
        return compareImages(
            {.test = test, .reference = reference, .reference_variance = &variance});
    };
    EXPECT_TRUE(compare(half).judged);
    EXPECT_FALSE(compare(more).judged);
    EXPECT_FALSE(compare(all).judged);
    EXPECT_EQ(compare(all).noise_share, 1.0);
    EXPECT_EQ(compare(all).rel_rmse, 0.0);  // clamped, not NaN
}

TEST(Compare, QuantilesOfTheReferencesNoise) {
    // Of a normal variable's absolute values half lie below 0.67449 deviations, 99% below 2.57583.
    const Image<vec3> reference(300, 40, vec3(1.0f)), variance(300, 40, vec3(0.04f));
    const Comparison even =
        compareImages({.test = reference, .reference = reference, .reference_variance = &variance});
    EXPECT_NEAR(even.noise_median, 0.67449 * 0.2 / 1.01, 1e-5);
    EXPECT_NEAR(even.noise_p99, 2.57583 * 0.2 / 1.01, 1e-5);

    // A tenth of the pixels noisy, the others exact: of all 99% lie below 90% of the noisy ones.
    Image<vec3> some(300, 40);
    for (int x = 0; x < 30; ++x) {
        for (int y = 0; y < 40; ++y) {
            some.at(x, y) = vec3(0.04f);
        }
    }
    const Comparison few =
        compareImages({.test = reference, .reference = reference, .reference_variance = &some});
    EXPECT_EQ(few.noise_median, 0.0);
    EXPECT_NEAR(few.noise_p99, 1.64485 * 0.2 / 1.01, 1e-3);

    // A reference without noise, or with a variance that is none.
    const Image<vec3> none(300, 40), negative(300, 40, vec3(-1.0f));
    for (const Image<vec3>* exact : {&none, &negative}) {
        const Comparison c =
            compareImages({.test = reference, .reference = reference, .reference_variance = exact});
        EXPECT_EQ(c.noise_median, 0.0);
        EXPECT_EQ(c.noise_p99, 0.0);
    }
    const Image<vec3> black(300, 40);
    const Comparison dark =
        compareImages({.test = black, .reference = black, .reference_variance = &variance});
    EXPECT_EQ(dark.noise_median, std::numeric_limits<double>::infinity());
}

TEST(Compare, PixelsOfOtherTrianglesAreExcluded) {
    const Image<vec3> reference(4, 1, vec3(1.0f));
    Image<vec3> test(4, 1, vec3(9.0f));
    test.at(0, 0) = vec3(1.5f);
    Image<uint32_t> seen_test(4, 1, 7u), seen_reference(4, 1, 7u);
    seen_test.at(1, 0) = 8u;            // another triangle
    seen_test.at(2, 0) = kNoPrimitive;  // nothing, where the reference sees something
    seen_test.at(3, 0) = kNoPrimitive;  // nothing in both
    seen_reference.at(3, 0) = kNoPrimitive;
    const CompareInput input{.test = test,
                             .reference = reference,
                             .test_primitive = &seen_test,
                             .reference_primitive = &seen_reference};
    const Comparison c = compareImages(input);
    EXPECT_EQ(c.excluded, 2);
    EXPECT_EQ(c.compared, 1);
    EXPECT_NEAR(c.rel_rmse, 0.5, kRounding);
    EXPECT_NEAR(c.max, 0.5 / 1.01, kRounding);
    const Image<vec3> map = heatmap(input);
    EXPECT_EQ(map.at(1, 0), vec3(0.5f));
    EXPECT_EQ(map.at(2, 0), vec3(0.5f));
    EXPECT_EQ(map.at(3, 0), vec3(0.0f));
}

TEST(Compare, NothingToCompareIsNotJudged) {
    const Image<vec3> image(2, 2, vec3(1.0f));
    const Image<uint32_t> nothing(2, 2, kNoPrimitive);
    const Comparison c = compareImages({.test = image,
                                        .reference = image,
                                        .test_primitive = &nothing,
                                        .reference_primitive = &nothing});
    EXPECT_EQ(c.compared, 0);
    EXPECT_EQ(c.excluded, 0);
    EXPECT_FALSE(c.judged);
    EXPECT_EQ(c.rel_rmse, 0.0);
    EXPECT_FALSE(compareImages({.test = Image<vec3>(), .reference = Image<vec3>()}).judged);
}

TEST(Compare, BlackReference) {
    const Image<vec3> black(2, 1, vec3(0.0f)), grey(2, 1, vec3(0.1f)), negative(2, 1, vec3(-0.1f));
    const Comparison same = compareImages({.test = black, .reference = black});
    EXPECT_EQ(same.rel_rmse, 0.0);
    EXPECT_EQ(same.max, 0.0);
    EXPECT_TRUE(same.judged);
    const Comparison c = compareImages({.test = grey, .reference = black});
    EXPECT_EQ(c.rel_rmse, static_cast<double>(kInfinity));
    EXPECT_EQ(c.rel_mse, static_cast<double>(kInfinity));
    EXPECT_EQ(c.bias, static_cast<double>(kInfinity));
    EXPECT_EQ(c.median, static_cast<double>(kInfinity));
    EXPECT_EQ(c.tile_max, static_cast<double>(kInfinity));
    EXPECT_TRUE(c.judged);
    EXPECT_EQ(compareImages({.test = negative, .reference = black}).bias,
              -static_cast<double>(kInfinity));
    EXPECT_EQ(heatmap({.test = grey, .reference = black}).at(0, 0), viridis(1.0f));
}

void expectInputError(const CompareInput& input, const std::string& part) {
    try {
        compareImages(input);
        ADD_FAILURE() << "no error; expected " << part;
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ExitCode::kInput);
        EXPECT_NE(std::string(error.what()).find(part), std::string::npos) << error.what();
    }
}

TEST(Compare, OtherSizesAreAnInputError) {
    const Image<vec3> reference(3, 2), test(2, 3);
    expectInputError({.test = test, .reference = reference}, "2x3");
    expectInputError({.test = test, .reference = reference}, "3x2");
    expectInputError({.test = reference, .reference = reference, .reference_variance = &test},
                     "variance");
    const Image<uint32_t> primitive(2, 3);
    expectInputError({.test = reference,
                      .reference = reference,
                      .test_primitive = &primitive,
                      .reference_primitive = &primitive},
                     "primitive");
    EXPECT_THROW(heatmap({.test = test, .reference = reference}), Error);
}

TEST(Compare, NonFiniteSamplesAreAnInputError) {
    const Image<vec3> good(4, 3, vec3(1.0f));
    Image<vec3> bad = good;
    bad.at(3, 1) = vec3(1.0f, NAN, 1.0f);
    bad.at(0, 2) = vec3(kInfinity);
    expectInputError({.test = bad, .reference = good}, "test image: pixel (3, 1)");
    expectInputError({.test = good, .reference = bad}, "reference image: pixel (3, 1)");
    expectInputError({.test = good, .reference = good, .reference_variance = &bad},
                     "variance: pixel (3, 1)");
}

TEST(Heatmap, DecadesOfRelativeError) {
    // b + 1% of the mean is 1.01 everywhere.
    const Image<vec3> reference(5, 1, vec3(1.0f));
    Image<vec3> test = reference;
    const double errors[] = {0.0, 1e-3, std::pow(10.0, -1.5), 1.0, 50.0};
    const float expected[] = {0.0f, 0.0f, 0.5f, 1.0f, 1.0f};
    for (int i = 0; i < 5; ++i) {
        test.at(i, 0) += vec3(static_cast<float>(errors[i] * 1.01));
    }
    const Image<vec3> map = heatmap({.test = test, .reference = reference});
    for (int i = 0; i < 5; ++i) {
        EXPECT_LT(glm::distance(map.at(i, 0), viridis(expected[i])), 1e-3f) << i;
    }
}

TEST(Heatmap, ViridisMatchesItsTable) {
    constexpr float kFitError = 0.02f;
    const auto expect = [&](float t, const vec3& colour) {
        const vec3 difference = glm::abs(viridis(t) - colour);
        EXPECT_LT(std::max({difference.x, difference.y, difference.z}), kFitError) << t;
    };
    expect(0.0f, vec3(0.267004f, 0.004874f, 0.329415f));
    expect(0.25f, vec3(0.229739f, 0.322361f, 0.545706f));
    expect(0.5f, vec3(0.127568f, 0.566949f, 0.550556f));
    expect(0.75f, vec3(0.369214f, 0.788888f, 0.382914f));
    expect(1.0f, vec3(0.993248f, 0.906157f, 0.143936f));
    float previous = -1.0f;
    for (int i = 0; i <= 100; ++i) {
        const float luma =
            glm::dot(viridis(0.01f * static_cast<float>(i)), vec3(0.2126f, 0.7152f, 0.0722f));
        EXPECT_GT(luma, previous);
        previous = luma;
    }
    EXPECT_EQ(viridis(-1.0f), viridis(0.0f));
    EXPECT_EQ(viridis(2.0f), viridis(1.0f));
}

}  // namespace
}  // namespace sheen
