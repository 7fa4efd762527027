// The direct layer of the scenes that come with Sheen against the reference's, away from the edges
// of shadows, which a shadow map draws a few texels soft. The edges are found in the reference's
// image alone, so that what the shadow maps get wrong cannot hide itself.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

#include "metrics/compare.h"
#include "test_reference.h"
#include "test_stage.h"

namespace sheen {
namespace {

constexpr int kSize = 512;
// The bounds on the direct layer, and how far from an edge of a shadow (in both axes) they hold.
constexpr double kBias = 0.005, kRmse = 0.03;
constexpr int kEdgePixels = 2;
// An edge of a shadow is where one of two neighbours is lit by a light and the other would be but
// for what is in between. No threshold is needed, textures and the rims of spots are no edges, and
// neither are creases, unless a shadow ends there: then they are, since the map's filter reaches
// across a crease as across a plane. Neighbours are a third of a pixel apart, which finds slivers
// of light that pass between the centres of pixels.
constexpr int kFine = 3;

enum class State : char { kLit, kShadowed, kTurnedAway };

// What one light does to each third of a pixel. Beyond a spot's cone it is turned away.
Image<State> statesOf(const Scene& scene, const PunctualLight& light) {
    Scene alone = scene;
    alone.lights = {light};
    const Frame f = firstHits(alone, kFine * kSize, kFine * kSize);
    Image<State> states(f.width(), f.width(), State::kTurnedAway);
    const vec3 eye(scene.cameras.front().world_from_camera[3]);
    for (size_t i = 0; i < states.pixels.size(); ++i) {
        if (f.primitive.pixels[i] == kNoPrimitive) {
            continue;
        }
        if (f.direct.pixels[i] != vec3(0.0f)) {
            states.pixels[i] = State::kLit;
            continue;
        }
        const vec3& p = f.position.pixels[i];
        const vec3 n_g = shared::faceViewer(
            geometricNormal(scene, static_cast<int>(f.primitive.pixels[i])), eye - p);
        const LightSample l = shared::sampleLight(light, p);
        if (glm::dot(f.normal.pixels[i], l.wi) > 0.0f && glm::dot(n_g, l.wi) > 0.0f &&
            l.irradiance != vec3(0.0f)) {
            states.pixels[i] = State::kShadowed;
        }
    }
    return states;
}

// 1 for every pixel within kEdgePixels of an edge of a shadow.
Image<char> nearShadowEdges(const Scene& scene) {
    Image<char> mask(kSize, kSize, 0);
    const auto mark = [&](int x, int y) {
        for (int v = std::max(y - kEdgePixels, 0); v <= std::min(y + kEdgePixels, kSize - 1); ++v) {
            for (int u = std::max(x - kEdgePixels, 0); u <= std::min(x + kEdgePixels, kSize - 1);
                 ++u) {
                mask.at(u, v) = 1;
            }
        }
    };
    for (const PunctualLight& light : scene.lights) {
        const Image<State> states = statesOf(scene, light);
        const auto check = [&](int x, int y, int u, int v) {
            const auto [a, b] = std::minmax({states.at(x, y), states.at(u, v)});
            if (a == State::kLit && b == State::kShadowed) {
                mark(x / kFine, y / kFine);
                mark(u / kFine, v / kFine);
            }
        };
        for (int y = 0; y < states.height; ++y) {
            for (int x = 0; x < states.width; ++x) {
                if (x + 1 < states.width) {
                    check(x, y, x + 1, y);
                }
                if (y + 1 < states.height) {
                    check(x, y, x, y + 1);
                }
            }
        }
    }
    return mask;
}

// The direct layer where records rasterise, without what they do afterwards.
GBuffer directLight(const Scene& scene) {
    gl::WorkerPool pool(1);
    GpuScene gpu;
    pool.runOnFirst([&] { gpu = uploadScene(scene); });
    renderShadowMaps(pool, scene, gpu);
    GBuffer g = renderGBuffer(Tracer(scene), scene.cameras.front(), kSize, kSize);
    lightGBuffer(pool, gpu, g);
    pool.runOnFirst([&] { gpu = {}; });
    return g;
}

struct Expected {
    const char* scene;
    // Share of pixels, about half above what it is: a mask that hid the image would pass anything.
    double most_masked;
};
void PrintTo(const Expected& expected, std::ostream* out) { *out << expected.scene; }

class DirectLayer : public testing::TestWithParam<Expected> {};

TEST_P(DirectLayer, HoldsItsBoundsAwayFromShadowEdges) {
    const Scene scene = loadScene(fmt::format("{}/{}.glb", SHEEN_SCENES, GetParam().scene));
    const GBuffer g = directLight(scene);
    const Frame reference = firstHits(scene, kSize, kSize);
    Image<vec3> direct(kSize, kSize);
    for (size_t i = 0; i < direct.pixels.size(); ++i) {
        direct.pixels[i] = g.direct.pixels[i];
    }
    Image<uint32_t> primitive = g.primitive;
    const auto compare = [&] {
        return compareImages({.test = direct,
                              .reference = reference.direct,
                              .test_primitive = &primitive,
                              .reference_primitive = &reference.primitive});
    };
    const Comparison everywhere = compare();
    // compareImages() leaves out pixels that see different triangles: let the masked ones do.
    const Image<char> mask = nearShadowEdges(scene);
    double masked = 0.0;
    for (size_t i = 0; i < mask.pixels.size(); ++i) {
        if (mask.pixels[i] != 0) {
            primitive.pixels[i] = ~reference.primitive.pixels[i];
            masked += 1.0 / kSize / kSize;
        }
    }
    const Comparison away = compare();
    std::printf(
        "%s: rel_rmse %.2f%%, bias %+.2f%%; away from shadow edges (%.1f%% masked) "
        "rel_rmse %.2f%%, bias %+.2f%%\n",
        GetParam().scene, 100.0 * everywhere.rel_rmse, 100.0 * everywhere.bias, 100.0 * masked,
        100.0 * away.rel_rmse, 100.0 * away.bias);
    EXPECT_LE(away.rel_rmse, kRmse);
    EXPECT_LE(std::abs(away.bias), kBias);
    EXPECT_LE(masked, GetParam().most_masked);
}

INSTANTIATE_TEST_SUITE_P(Scenes, DirectLayer,
                         testing::Values(Expected{"cornell_diffuse", 0.025},
                                         Expected{"cornell_glossy", 0.025},
                                         Expected{"venus_glossy", 0.055}, Expected{"atrium", 0.19}),
                         [](const auto& info) { return std::string(info.param.scene); });

}  // namespace
}  // namespace sheen
