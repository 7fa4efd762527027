// Images that become better while they are looked at.
#include <gtest/gtest.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <string>
#include <thread>

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

// Two images that each err by up to 3%.
constexpr double kSameWithinErrors = 0.05;
constexpr double kHintsWithin = 0.4;
constexpr double kMostGrowth = 16.0;  // MiB

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

TEST(Live, TheFirstFrameIsLitByHints) {
    const Scene scene = glossyRoom();
    LiveImage live(scene, liveParams());
    live.step(0.0);
    EXPECT_EQ(live.progress().records, 0);
    RenderParams same = liveParams();
    same.width = live.progress().width;
    same.height = live.progress().height;
    EXPECT_LT(relativeRms(live.frame().indirect, renderFrame(scene, same).frame.indirect),
              kHintsWithin);
}

// Of a hemisphere as a disc (PixelParts), its luminance.
float irradianceOf(const Image<vec3>& disc) {
    float sum = 0.0f;
    int count = 0;
    for (int y = 0; y < disc.height; ++y) {
        for (int x = 0; x < disc.width; ++x) {
            const vec2 p = (2.0f * vec2(x, y) + 1.0f) / static_cast<float>(disc.width) - 1.0f;
            const float cosine = 1.0f - glm::dot(p, p);
            if (cosine > 0.0f) {
                sum += cosine * luminance(disc.at(x, y));
                ++count;
            }
        }
    }
    return 2.0f * kPi * sum / static_cast<float>(count);
}

TEST(Live, APixelIsTakenApart) {
    LiveImage live(glossyRoom(), liveParams());
    EXPECT_FALSE(live.partsAt(vec2(0.5f)));
    finish(live);
    EXPECT_FALSE(live.partsAt(vec2(1.0f, 0.5f)));
    int diffuse = 0, glossy = 0;
    for (int k = 0; k < 16; ++k) {
        const vec2 place = (vec2(k % 4, k / 4) + 0.5f) / 4.0f;
        const std::optional<PixelParts> parts = live.partsAt(place);
        ASSERT_TRUE(parts);
        ASSERT_TRUE(parts->seen);
        const ivec2 pixel = parts->pixel;
        EXPECT_EQ(pixel, ivec2(place * static_cast<float>(kSize)));
        EXPECT_EQ(parts->indirect, live.frame().indirect.at(pixel.x, pixel.y));
        ASSERT_FALSE(parts->records.empty());
        float sum = 0.0f;
        for (const PixelParts::Serving& serving : parts->records) {
            EXPECT_LE(serving.share, parts->records.front().share);
            EXPECT_LT(serving.distance, serving.reach);
            sum += serving.share;
        }
        EXPECT_NEAR(sum, 1.0f, 1e-5f);
        const float irradiance = irradianceOf(parts->hemisphere);
        const vec3 albedo = live.frame().albedo.at(pixel.x, pixel.y);
        const vec3 shown = live.frame().indirect_diffuse.at(pixel.x, pixel.y);
        if (luminance(albedo) > 0.0f) {
            EXPECT_NEAR(luminance(shown) * kPi / luminance(albedo) / irradiance, 1.0f, 0.25f) << k;
        }
        if (parts->order == shared::DIFFUSE_ORDER) {
            ++diffuse;
            EXPECT_TRUE(parts->reconstruction.empty());
        } else {
            ++glossy;
            EXPECT_NEAR(irradianceOf(parts->reconstruction) / irradiance, 1.0f, 0.15f) << k;
        }
    }
    EXPECT_GT(diffuse, 0);
    EXPECT_GT(glossy, 0);
    // What is no longer true is not told.
    live.edit([](Scene& scene) { scene.lights.at(0).intensity *= 2.0f; });
    EXPECT_FALSE(live.partsAt(vec2(0.5f)));
}

// Resident memory, MiB. Software OpenGL keeps its buffers and textures there as well.
double residentMemory() {
    std::ifstream status("/proc/self/statm");
    double pages = 0.0;
    status >> pages >> pages;
    return pages * static_cast<double>(sysconf(_SC_PAGESIZE)) / (1024.0 * 1024.0);
}

// 300 of them, or as many as SHEEN_FRAMES says: bench/live_frames.
TEST(Live, FramesLeakNothing) {
    const char* wanted = std::getenv("SHEEN_FRAMES");
    const int frames = wanted != nullptr ? std::stoi(wanted) : 300;
    LiveImage live(glossyRoom(), liveParams());
    double before = 0.0;
    for (int i = 0; i < frames; ++i) {
        const float t = 0.1f * static_cast<float>(i);
        if (i % 3 == 0) {
            live.look(lookAt(vec3(0.1f * std::sin(t), 0.1f * std::cos(t), 0.93f),
                             vec3(-0.1f, -0.5f, -0.3f)));
        } else if (i % 30 == 1) {
            live.edit([&](Scene& scene) {
                scene.lights.at(0).position.x = 0.2f * std::sin(t);
                scene.materials.at(0).params.roughness = 0.5f + 0.4f * std::sin(t);
            });
        }
        live.step(0.01);
        if (i == frames / 3) {
            before = residentMemory();
        }
    }
    EXPECT_LT(residentMemory() - before, kMostGrowth);
}

// What refines is given up when something else is wanted; what it found is kept.
TEST(Live, AStepThatIsOutdatedEndsWithoutAFrame) {
    LiveImage live(glossyRoom(), liveParams());
    const std::atomic<bool> outdated = true;
    live.step(0.0, &outdated);  // the first is seen in any case
    ASSERT_FALSE(live.frame().indirect.empty());
    live.step(0.0);
    live.step(0.0);
    const Frame before = live.frame();
    const int records = live.progress().records;
    ASSERT_GT(records, 0);
    EXPECT_FALSE(live.step(0.0, &outdated));
    EXPECT_FALSE(live.done());
    EXPECT_EQ(live.frame().indirect.pixels, before.indirect.pixels);
    live.step(0.0);
    EXPECT_GE(live.progress().records - live.progress().records_new, records);

    while (live.progress().width < kSize || live.progress().uncovered > 0) {
        live.step(0.01);
    }
    // Wherever in a step it happens.
    for (int i = 0; i < 60 && !live.done(); ++i) {
        std::atomic<bool> later = false;
        std::thread other([&] {
            std::this_thread::sleep_for(std::chrono::microseconds(300 * i));
            later = true;
        });
        live.step(0.02, &later);
        other.join();
        ASSERT_EQ(live.frame().width(), live.progress().width);
        const std::vector<vec3>& light = live.frame().indirect.pixels;
        ASSERT_FALSE(light.empty());
        ASSERT_EQ(std::count(light.begin(), light.end(), vec3(0.0f)), 0);
    }
    finish(live);
    EXPECT_LT(
        relativeRms(live.frame().indirect, renderFrame(glossyRoom(), liveParams()).frame.indirect),
        kSameWithinErrors);
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
