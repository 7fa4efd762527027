// Images that become better while they are looked at.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>

#include "core/error.h"
#include "render/live.h"
#include "test_render.h"

namespace sheen {
namespace {

constexpr int kSize = 40;

RenderParams liveParams() {
    RenderParams params = smallRender(kSize, kSize);
    params.all_layers = false;
    return params;
}

// So many that none is needed, each short.
int finish(LiveImage& live) {
    int steps = 0;
    for (; !live.done() && steps < 2000; ++steps) {
        live.step(0.01);
    }
    EXPECT_TRUE(live.done());
    return steps;
}

double relativeRms(const Image<vec3>& a, const Image<vec3>& b) {
    EXPECT_EQ(a.pixels.size(), b.pixels.size());
    double squares = 0.0, sum = 0.0;
    for (size_t i = 0; i < std::min(a.pixels.size(), b.pixels.size()); ++i) {
        const double d = luminance(a.pixels[i]) - luminance(b.pixels[i]);
        squares += d * d;
        sum += luminance(b.pixels[i]);
    }
    const auto n = static_cast<double>(b.pixels.size());
    return std::sqrt(squares / n) / (sum / n);
}

// Two images that each err by up to 3%.
constexpr double kSameWithinErrors = 0.05;

TEST(Live, BeginsCoarseAndEndsAsTheImageThatRenderMakes) {
    const Scene scene = glossyRoom();
    LiveImage live(scene, liveParams());
    EXPECT_FALSE(live.done());
    live.step(0.0);
    EXPECT_LT(live.progress().width, kSize);
    EXPECT_EQ(live.frame().width(), live.progress().width);
    finish(live);
    EXPECT_EQ(live.frame().width(), kSize);
    EXPECT_EQ(live.progress().uncovered, 0);
    EXPECT_GT(live.progress().records, 0);
    const RenderResult alone = renderFrame(scene, liveParams());
    EXPECT_EQ(std::memcmp(live.frame().direct.pixels.data(), alone.frame.direct.pixels.data(),
                          alone.frame.direct.pixels.size() * sizeof(vec3)),
              0);
    EXPECT_LT(relativeRms(live.frame().indirect, alone.frame.indirect), kSameWithinErrors);
}

TEST(Live, EveryFrameIsLitBeforeItIsComplete) {
    LiveImage live(glossyRoom(), liveParams());
    while (!live.done()) {
        live.step(0.0);
        const Image<vec3> seen = beauty(live.frame());
        size_t black = 0;
        for (size_t i = 0; i < seen.pixels.size(); ++i) {
            ASSERT_TRUE(finite(seen.pixels[i]));
            black += live.frame().indirect.pixels[i] == vec3(0.0f) ? 1 : 0;
        }
        EXPECT_EQ(black, 0u) << seen.width;
    }
}

TEST(Live, AnotherViewUsesWhatIsThere) {
    LiveImage live(glossyRoom(), liveParams());
    finish(live);
    live.look(lookAt(vec3(0.05f, 0.1f, 0.93f), vec3(-0.1f, -0.5f, -0.3f)));
    EXPECT_FALSE(live.done());
    live.step(0.0);
    EXPECT_GT(live.progress().records - live.progress().records_new, 0);
    finish(live);
    EXPECT_GT(live.progress().records - live.progress().records_new, live.progress().records_new);
    live.step(0.0);  // changes nothing
    EXPECT_TRUE(live.done());
}

TEST(Live, EditsDiscardWhatDependsOnThemAndNothingElse) {
    const Scene scene = glossyRoom();
    LiveImage live(scene, liveParams());
    finish(live);
    const Frame before = live.frame();
    live.edit([](Scene& edited) { edited.lights.at(0).intensity *= 0.5f; });
    finish(live);
    Scene dimmed = scene;
    dimmed.lights.at(0).intensity *= 0.5f;
    EXPECT_LT(relativeRms(live.frame().direct, renderFrame(dimmed, liveParams()).frame.direct),
              1e-6);
    EXPECT_LT(relativeRms(live.frame().indirect, renderFrame(dimmed, liveParams()).frame.indirect),
              kSameWithinErrors);

    live.edit([&](Scene& edited) {
        edited.lights = scene.lights;
        edited.materials.at(0).params.base_color = vec3(0.2f, 0.7f, 0.3f);
    });
    finish(live);
    Scene painted = scene;
    painted.materials.at(0).params.base_color = vec3(0.2f, 0.7f, 0.3f);
    EXPECT_LT(relativeRms(live.frame().direct, renderFrame(painted, liveParams()).frame.direct),
              1e-6);
    EXPECT_GT(relativeRms(live.frame().direct, before.direct), 0.01);

    // Another accuracy keeps what was gathered.
    RenderParams params = liveParams();
    params.placement.accuracy = 0.8f;
    live.setParams(params);
    live.step(0.0);
    EXPECT_GT(live.progress().records - live.progress().records_new, 0);
    // Another order does not.
    params.sh_order = 3;
    live.setParams(params);
    live.step(0.0);
    EXPECT_EQ(live.progress().records, live.progress().records_new);
}

TEST(Live, OtherMethodsAreRefused) {
    RenderParams params = liveParams();
    params.method = Method::kReference;
    EXPECT_THROW(LiveImage(glossyRoom(), params), Error);
}

TEST(Live, ScenesWithoutAnythingAreDone) {
    Scene empty;
    empty.cameras.push_back(Camera{});
    LiveImage live(empty, liveParams());
    finish(live);
    EXPECT_EQ(live.progress().records, 0);
}

}  // namespace
}  // namespace sheen
