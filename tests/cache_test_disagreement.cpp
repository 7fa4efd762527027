// How records' reaches heed what their neighbours see.
#include <gtest/gtest.h>

#include <array>

#include "test_placement.h"

namespace sheen {
namespace {

// Short reaches, so that many records fit into the image, and no other limit that the light sets.
PlacementParams disagreeing(float disagreement) {
    PlacementParams params;
    params.control = ErrorControl::kSplitSphere;
    params.min_pixels = 2.0f;
    params.max_pixels = 12.0f;
    params.neighbour_clamping = false;
    params.disagreement = disagreement;
    return params;
}

// Waves along x on the right, the same everywhere on the left.
float wavesOnTheRight(const vec3& p) {
    return 1.0f + (p.x > 0.0f ? 0.5f * std::sin(4.0f * p.x) : 0.0f);
}

// No gradient tells of them.
const Change kWaves = [](const RecordSite& site, GatheredRecord& g) {
    g.record.irradiance *= wavesOnTheRight(site.position);
};

// Where the records are and how far they reach.
std::vector<vec4> reaches(const Placement& placement) {
    std::vector<vec4> result;
    for (const Record& r : placement.cache.records) {
        result.emplace_back(r.position, r.radius);
    }
    return result;
}

// Records on each side, away from the middle.
std::array<int, 2> countSides(const Placement& placement) {
    std::array<int, 2> count = {};
    for (const Record& r : placement.cache.records) {
        if (std::abs(r.position.x) > 0.3f) {
            ++count[r.position.x < 0.0f ? 0 : 1];
        }
    }
    return count;
}

TEST(Disagreement, PlacesMoreRecordsWhereLightVaries) {
    const Stage stage = makeStage(0, 0);
    const Placement off = place(stage, disagreeing(0.0f), kWaves);
    const Placement on = place(stage, disagreeing(0.2f), kWaves);
    expectCovered(stage, disagreeing(0.2f), on);
    EXPECT_GT(countSides(off)[0], 10);
    EXPECT_NEAR(countSides(off)[1], countSides(off)[0], 0.1 * countSides(off)[0]);
    EXPECT_GT(countSides(on)[1], 2 * countSides(off)[1]);
    EXPECT_NEAR(countSides(on)[0], countSides(off)[0], 0.1 * countSides(off)[0]);
    // The stricter, the more.
    EXPECT_GT(countSides(place(stage, disagreeing(0.05f), kWaves))[1], countSides(on)[1]);
}

TEST(Disagreement, ConstantLightChangesNothing) {
    const Stage stage = makeStage(0, 4);
    expectSame(place(stage, disagreeing(0.2f)), place(stage, disagreeing(0.0f)));
}

TEST(Disagreement, LightThatGradientsForetellChangesNothing) {
    const Stage stage = makeStage(0, 0);
    const auto slope = [](bool told) {
        return [told](const RecordSite& site, GatheredRecord& g) {
            const vec3 gradient(told ? 0.3f : 0.0f, 0.0f, 0.0f);
            g.record.irradiance = vec3(2.0f + 0.3f * site.position.x);
            g.record.translation_r = g.record.translation_g = g.record.translation_b = gradient;
        };
    };
    const Placement off = place(stage, disagreeing(0.0f), slope(true));
    expectSame(place(stage, disagreeing(0.05f), slope(true)), off);
    EXPECT_GT(place(stage, disagreeing(0.05f), slope(false)).cache.records.size(),
              2 * off.cache.records.size());
}

TEST(Disagreement, IsNotAskedAtZero) {
    const Stage stage = makeStage(0, 0);
    EXPECT_EQ(reaches(place(stage, disagreeing(0.0f), kWaves)),
              reaches(place(stage, disagreeing(0.0f))));
}

TEST(Disagreement, IsRelativeToTheLight) {
    const Stage stage = makeStage(0, 0);
    // A power of two rounds alike.
    const Change brighter = [](const RecordSite& site, GatheredRecord& g) {
        kWaves(site, g);
        g.record.irradiance *= 1024.0f;
    };
    EXPECT_EQ(reaches(place(stage, disagreeing(0.2f), brighter)),
              reaches(place(stage, disagreeing(0.2f), kWaves)));
}

TEST(Disagreement, NeverShrinksAReachBelowItsLeast) {
    const Stage stage = makeStage(0, 0);
    const PlacementParams params = disagreeing(1e-4f);
    const Placement placement = place(stage, params, [](const RecordSite& site, GatheredRecord& g) {
        // Black or bright, by turns of a hundredth.
        const bool lit = static_cast<int>(std::floor(100.0f * site.position.x)) % 2 == 0;
        g.record.irradiance = vec3(lit ? 100.0f : 0.0f);
    });
    expectCovered(stage, params, placement);
    for (const Record& r : placement.cache.records) {
        EXPECT_GE(params.servingWeight().accuracy * r.radius,
                  0.999f * params.min_pixels * footprintOf(stage, r));
    }
}

TEST(Disagreement, GlossyPixelsJudgeWhatTheyReflect) {
    Stage stage = makeStage(4, 4);
    stage.receivers.f0.assign(kWidth * kHeight, vec3(0.9f));
    // Band 0 alone, so that the mirrors look alike from every side; the irradiance stays.
    const auto reflecting = [](const std::function<float(const vec3&)>& light) {
        return [light](const RecordSite& site, GatheredRecord& g) {
            std::fill(g.sh.begin(), g.sh.end(), 0.0f);
            for (int c = 0; c < 3; ++c) {
                g.sh[static_cast<size_t>(c * shLayout(site.order).coefficients())] =
                    light(site.position);
            }
        };
    };
    const auto constant = reflecting([](const vec3&) { return 1.0f; });
    const auto without = countSides(place(stage, disagreeing(0.2f), constant));
    const auto with = countSides(place(stage, disagreeing(0.2f), reflecting(wavesOnTheRight)));
    EXPECT_GT(with[1], 2 * without[1]);
    EXPECT_NEAR(with[0], without[0], 0.1 * without[0]);
}

}  // namespace
}  // namespace sheen
