// Radiance hints against references that are kept: they are approximate, and no worse than
// docs/hints.md says.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "image/exr.h"
#include "metrics/compare.h"
#include "render/render.h"

namespace sheen {
namespace {

// What hints of default parameters err by now, in percent.
struct MeasuredByHints {
    const char* scene;
    double rel_rmse, bias, median;
};
void PrintTo(const MeasuredByHints& row, std::ostream* out) { *out << row.scene; }

// What chance changes: where samples and hints lie.
constexpr double kFactor = 1.15;
constexpr double kBias = 2.5;  // percent of the image

class HintsAccuracy : public testing::TestWithParam<MeasuredByHints> {};

TEST_P(HintsAccuracy, IsNotWorseThanItWas) {
    const MeasuredByHints& row = GetParam();
    const LoadedExr truth = readExr(fmt::format("{}/{}.exr", SHEEN_REFERENCES, row.scene));
    RenderParams params;
    params.method = Method::kHints;
    params.width = truth.width;
    params.height = truth.height;
    params.bounces = 1;  // as the references have them
    params.quiet = true;
    const RenderResult result =
        renderFrame(loadScene(fmt::format("{}/{}.glb", SHEEN_SCENES, row.scene)), params);
    EXPECT_EQ(result.stats.nonfinite_pixels, 0);
    EXPECT_LT(result.stats.pixels_uncovered, result.stats.pixels_geometry / 50);

    const Comparison c = compareImages({.test = result.frame.indirect,
                                        .reference = colorLayer(truth, "indirect"),
                                        .reference_variance = &colorLayer(truth, "variance"),
                                        .test_primitive = &result.frame.primitive,
                                        .reference_primitive = &truth.primitive});
    std::printf("%s: rel_rmse %.2f%%, bias %+.2f%%, median %.2f%%, unseen %d\n", row.scene,
                100.0 * c.rel_rmse, 100.0 * c.bias, 100.0 * c.median,
                result.stats.pixels_uncovered);
    EXPECT_EQ(c.excluded, 0);
    EXPECT_LE(100.0 * c.rel_rmse, kFactor * row.rel_rmse);
    EXPECT_LE(100.0 * std::abs(c.bias), std::abs(row.bias) + kBias);
    EXPECT_LE(100.0 * c.median, kFactor * row.median);
}

INSTANTIATE_TEST_SUITE_P(Scenes, HintsAccuracy,
                         testing::Values(MeasuredByHints{"cornell_diffuse", 20.4, -0.2, 5.4},
                                         MeasuredByHints{"cornell_glossy", 36.4, 4.4, 7.9},
                                         MeasuredByHints{"venus_glossy", 19.5, 1.0, 6.7},
                                         MeasuredByHints{"atrium", 31.2, -3.0, 6.8}),
                         [](const auto& info) { return std::string(info.param.scene); });

}  // namespace
}  // namespace sheen
