// Probes: where they lie, and what estimateError() makes of them.
#include <gtest/gtest.h>

#include <cmath>

#include "cache/probes.h"
#include "test_placement.h"

namespace sheen {
namespace {

// An image of light 1 on the test floor, `neighbours` expecting relative errors of `expected`.
struct Judged {
    Stage stage = makeStage(0, 0);
    Image<vec3> image{kWidth, kHeight, vec3(1.0f)};
    NeighbourErrors neighbours;

    explicit Judged(float expected) {
        neighbours.squares = Image<float>(kWidth, kHeight);
        for (size_t i = 0; i < image.pixels.size(); ++i) {
            if (stage.receivers.seen(i) && isJudged(i, kWidth)) {
                neighbours.squares.pixels[i] = expected * expected;
            }
        }
        neighbours.rel_rmse = expected;
    }
    std::vector<Probe> probes(int count) const {
        return chooseProbes(neighbours, stage.receivers, image, count);
    }
    // The truth at pixel i is 1 - error(i); probes see it with noise.
    ErrorEstimate estimate(const std::function<float(int)>& error, float noise = 0.02f,
                           int count = 200) const {
        std::vector<Probe> chosen = probes(count);
        Random random(11);
        for (Probe& p : chosen) {
            for (vec3& light : p.light) {
                light = vec3(1.0f - error(p.pixel) + random.uniform(-noise, noise));
            }
        }
        return estimateError(neighbours, chosen, stage.receivers, image);
    }
    int judgedPixels() const {
        int count = 0;
        for (size_t i = 0; i < image.pixels.size(); ++i) {
            count += stage.receivers.seen(i) && isJudged(i, kWidth) ? 1 : 0;
        }
        return count;
    }
};

TEST(Probes, StandForAllJudgedPixels) {
    Judged judged(0.01f);
    // Most of the error is expected in a few pixels.
    for (int x = 0; x < 10; x += 2) {
        judged.neighbours.squares.at(kWidth / 2 + x, kHeight - 2) = 1.0f;
    }
    const std::vector<Probe> probes = judged.probes(200);
    EXPECT_EQ(probes.size(), 200u);
    double stand_for = 0.0;
    int where_expected = 0;
    for (const Probe& p : probes) {
        EXPECT_TRUE(judged.stage.receivers.seen(static_cast<size_t>(p.pixel)));
        EXPECT_TRUE(isJudged(static_cast<size_t>(p.pixel), kWidth));
        stand_for += static_cast<double>(p.stands_for);
        where_expected += judged.neighbours.squares.pixels[static_cast<size_t>(p.pixel)] == 1.0f;
    }
    EXPECT_NEAR(stand_for / judged.judgedPixels(), 1.0, 0.15);
    EXPECT_GT(where_expected, 60);
}

TEST(Probes, HalfOfThemWhereRaysAre) {
    Judged judged(0.01f);
    for (int x = 0; x < kWidth / 4; ++x) {
        judged.stage.receivers.by_rays[judged.stage.receivers.image.index(x, kHeight - 2)] = 1;
    }
    int by_rays = 0;
    for (const Probe& p : judged.probes(100)) {
        by_rays += judged.stage.receivers.by_rays[static_cast<size_t>(p.pixel)] != 0;
    }
    EXPECT_EQ(by_rays, 50);
}

TEST(ErrorEstimate, AgreesWithNeighboursThatAreRight) {
    const Judged judged(0.05f);
    const ErrorEstimate e = judged.estimate([](int i) { return i % 3 == 0 ? -0.05f : 0.05f; });
    EXPECT_NEAR(e.rel_rmse, 0.05, 0.01);
    EXPECT_LE(e.low, 0.05);
    EXPECT_GE(e.high, 0.05);
    EXPECT_LE(e.high / e.low, 3.001);
}

// All records are wrong alike: neighbours expect a tenth of it.
TEST(ErrorEstimate, SeesWhatRecordsGetWrongAlike) {
    const Judged judged(0.01f);
    const ErrorEstimate e = judged.estimate([](int) { return 0.1f; });
    EXPECT_NEAR(e.rel_rmse, 0.1, 0.02);
    EXPECT_LE(e.low, 0.1);
    EXPECT_GE(e.high, 0.1);
}

TEST(ErrorEstimate, NeighboursThatFearTooMuchAreCorrected) {
    const Judged judged(0.2f);
    const ErrorEstimate e = judged.estimate([](int) { return 0.05f; });
    EXPECT_LT(e.rel_rmse, 0.15);
    EXPECT_LE(e.low, 0.06);
}

TEST(ErrorEstimate, NoLightNoEstimate) {
    Judged judged(0.0f);
    judged.image = Image<vec3>(kWidth, kHeight);
    const ErrorEstimate e = judged.estimate([](int) { return 1.0f; });
    EXPECT_TRUE(std::isnan(e.rel_rmse));
    EXPECT_TRUE(std::isnan(e.low));
    EXPECT_TRUE(std::isnan(e.high));
}

}  // namespace
}  // namespace sheen
