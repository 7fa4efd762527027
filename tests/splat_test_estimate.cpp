// neighbourErrors() against the error itself, on light that is known.
#include <gtest/gtest.h>

#include <functional>

#include "cache/estimate.h"
#include "splat/splat.h"
#include "test_placement.h"

namespace sheen {
namespace {

// What docs/cache.md promises of the estimate.
constexpr double kFactor = 1.5;

struct Judged {
    double estimated = 0;
    double actual = 0;
};

// An image of the irradiance `light` as records tell it that gather `gathered`.
Judged judge(const PlacementParams& params, const std::function<float(const vec3&)>& light,
             const std::function<float(const vec3&)>& gathered,
             const Stage& stage = makeStage(0, 0)) {
    RecordField field;
    const Placement placement = place(
        stage, params,
        [&](const RecordSite& site, GatheredRecord& g) {
            g.record.irradiance = vec3(gathered(site.position));
        },
        &field);
    const Receivers& receivers = stage.receivers;
    const SplatBuffer splat = splatCpu(receivers, placement.cache, params.servingWeight());
    Image<vec3> image(kWidth, kHeight);
    double squares = 0.0;
    double sum = 0.0;
    int seen = 0;
    for (size_t i = 0; i < kWidth * kHeight; ++i) {
        if (!receivers.seen(i)) {
            continue;
        }
        const vec4 v = splat.irradiance.pixels[i];
        image.pixels[i] = vec3(v) / v.w;
        const double truth = light(receivers.positions[i]);
        squares += std::pow(image.pixels[i].x - truth, 2);
        sum += truth;
        ++seen;
    }
    return {.estimated = neighbourErrors(receivers, placement.cache, field.pixels,
                                         params.servingWeight(), image)
                             .rel_rmse,
            .actual = std::sqrt(squares * seen) / sum};
}

// Short reaches: many records.
PlacementParams shortReach() {
    PlacementParams params;
    params.max_pixels = 4.0f;
    params.disagreement = 0.0f;
    return params;
}

TEST(Estimate, ConstantLightHasNoError) {
    const auto light = [](const vec3&) { return 2.0f; };
    EXPECT_LT(judge(shortReach(), light, light).estimated, 1e-6);
}

TEST(Estimate, TracksTheErrorOfNoisyRecords) {
    const auto light = [](const vec3&) { return 1.0f; };
    for (float amount : {0.02f, 0.1f, 0.3f}) {
        Random random(7);
        const Judged j = judge(shortReach(), light,
                               [&](const vec3&) { return 1.0f + random.uniform(-amount, amount); });
        EXPECT_GT(j.actual, 0.05 * amount);
        EXPECT_LT(j.estimated, kFactor * j.actual) << amount;
        EXPECT_GT(j.estimated, j.actual / kFactor) << amount;
    }
}

TEST(Estimate, TracksTheErrorBetweenRecords) {
    for (float frequency : {6.0f, 12.0f}) {
        const auto light = [=](const vec3& p) { return 1.0f + 0.5f * std::sin(frequency * p.x); };
        const Judged j = judge(shortReach(), light, light);
        EXPECT_GT(j.actual, 0.01);
        EXPECT_LT(j.estimated, kFactor * j.actual) << frequency;
        EXPECT_GT(j.estimated, j.actual / kFactor) << frequency;
    }
}

void hide(Stage& stage, int x, int y) {
    const size_t i = stage.receivers.image.index(x, y);
    stage.receivers.footprints[i] = 0.0f;
    stage.receivers.orders[i] = kNoOrder;
}

TEST(Estimate, PixelsThatSeeNothingDoNotCount) {
    Stage stage = makeStage(0, 0);
    for (int y = 0; y < kHeight; ++y) {
        for (int x = kWidth / 8; x < kWidth; ++x) {
            hide(stage, x, y);
        }
    }
    Random random(3);
    const Judged j = judge(
        shortReach(), [](const vec3&) { return 1.0f; },
        [&](const vec3&) { return 1.0f + random.uniform(-0.1f, 0.1f); }, stage);
    EXPECT_LT(j.estimated, kFactor * j.actual);
    EXPECT_GT(j.estimated, j.actual / kFactor);
}

// One record of twenty is twice too bright; bright pixels stand alone, each right by its own
// record.
TEST(Estimate, WhatFewGetWrongIsNotExpectedOfRecordsThatNoneReaches) {
    Stage stage = makeStage(0, 0);
    const auto alone = [](int x, int y) { return x % 6 == 5 && y % 6 == 0; };
    for (int y = 0; y < kHeight; ++y) {
        for (int x = kWidth / 2; x < kWidth; ++x) {
            if (!alone(x, y)) {
                hide(stage, x, y);
            }
        }
    }
    PlacementParams params = shortReach();
    params.max_pixels = 2.0f;
    const auto light = [&](const vec3& p) { return p.x > 0.0f ? 50.0f : 1.0f; };
    int gathered = 0;
    const Judged j = judge(
        params, light,
        [&](const vec3& p) {
            const bool wrong = p.x < 0.0f && ++gathered % 20 == 0;
            return light(p) * (wrong ? 2.0f : 1.0f);
        },
        stage);
    // Whoever lies beside a wrong record is judged by it: more than what the patch alone leaves.
    EXPECT_LT(j.estimated, 2.0 * j.actual);
    EXPECT_GT(j.estimated, j.actual / kFactor);
}

TEST(Estimate, NothingIsKnownWhereNoRecordServesAnother) {
    Stage stage = makeStage(0, 0);
    constexpr int kPixel = kWidth * kHeight - 1;
    for (int i = 0; i < kPixel; ++i) {
        hide(stage, i % kWidth, i / kWidth);
    }
    ASSERT_TRUE(stage.receivers.seen(kPixel));
    const PlacementParams params;
    RecordField field;
    const Placement placement = place(stage, params, kNoChange, &field);
    ASSERT_EQ(placement.cache.records.size(), 1u);
    EXPECT_EQ(neighbourErrors(stage.receivers, placement.cache, field.pixels,
                              params.servingWeight(), Image<vec3>(kWidth, kHeight, vec3(1.0f)))
                  .rel_rmse,
              kInfinity);
}

TEST(Estimate, NothingSeenIsNoError) {
    Stage stage = makeStage(0, 0);
    stage.receivers.orders.assign(kWidth * kHeight, kNoOrder);
    EXPECT_EQ(neighbourErrors(stage.receivers, {}, {}, PlacementParams{}.servingWeight(),
                              Image<vec3>(kWidth, kHeight))
                  .rel_rmse,
              0.0);
}

}  // namespace
}  // namespace sheen
