// Traced direct light against the reference's.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cmath>

#include "light/direct.h"
#include "test_reference.h"
#include "test_stage.h"

namespace sheen {
namespace {

constexpr int kSize = 128;

GBuffer unlit(const Scene& scene) {
    return renderGBuffer(Tracer(scene), scene.cameras.front(), kSize, kSize);
}

class TracedDirect : public testing::TestWithParam<const char*> {};

// Both find the same points but for rounding, which moves edges of shadows and highlights: pixels
// that lie on one may differ, few do.
TEST_P(TracedDirect, IsTheReferencesButForEdges) {
    const Scene scene = loadScene(fmt::format("{}/{}.glb", SHEEN_SCENES, GetParam()));
    const GBuffer gbuffer = unlit(scene);
    const Tracer tracer(scene);
    const Image<vec3> direct = traceDirect(tracer, SceneLights(tracer), gbuffer);
    const Frame truth = firstHits(scene, kSize, kSize);
    int compared = 0, lit = 0, differ = 0;
    for (size_t i = 0; i < direct.pixels.size(); ++i) {
        EXPECT_EQ(gbuffer.direct.pixels[i], vec3(0.0f));
        if (truth.primitive.pixels[i] != gbuffer.primitive.pixels[i]) {
            continue;
        }
        ++compared;
        const vec3& expected = truth.direct.pixels[i];
        lit += expected != vec3(0.0f) ? 1 : 0;
        for (int c = 0; c < 3; ++c) {
            if (std::abs(direct.pixels[i][c] - expected[c]) > 5e-3f * expected[c] + 1e-5f) {
                ++differ;
                break;
            }
        }
    }
    EXPECT_GT(compared, kSize * kSize * 9 / 10);
    EXPECT_GT(lit, kSize * kSize / 50);
    EXPECT_LE(differ, kSize * kSize / 500);
}

INSTANTIATE_TEST_SUITE_P(Scenes, TracedDirect,
                         testing::Values("cornell_diffuse", "cornell_glossy", "venus_glossy",
                                         "atrium", "corridor"),
                         [](const auto& info) { return std::string(info.param); });

TEST(TracedDirect, BlackWithoutLightsOrGeometry) {
    Scene dark = cornellRoom(diffuseParams(vec3(0.6f)), diffuseParams(vec3(0.5f)));
    dark.lights.clear();
    Scene empty;
    empty.cameras.push_back(lookAt(vec3(0.0f), vec3(0, 0, -1)));
    for (const Scene& scene : {dark, empty}) {
        const Tracer tracer(scene);
        const Image<vec3> direct = traceDirect(tracer, SceneLights(tracer), unlit(scene));
        for (const vec3& pixel : direct.pixels) {
            ASSERT_EQ(pixel, vec3(0.0f));
        }
    }
}

}  // namespace
}  // namespace sheen
