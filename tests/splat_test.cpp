// The GPU's splat against the CPU's, and what compose() makes of the sums.
#include "splat/splat.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <set>

#include "sh/sh.h"
#include "test_scenes.h"
#include "test_stage.h"

namespace sheen {
namespace {

constexpr WeightParams kWeight = {.accuracy = 0.3f, .normal_weight = 1.0f, .slab = 0.2f};
// Sums of a few hundred single-precision products, added in another order; relative to the sum of
// what was added, which is larger than the result where signs differ.
constexpr float kSplatError = 1e-4f;

// Records at pixels spread over the image, of their pixels' classes, with made-up light.
RecordCache makeRecords(const Receivers& receivers, size_t stride, uint32_t seed) {
    Random random(seed);
    Random missed(seed + 1);
    RecordCache cache;
    for (size_t i = 0; i < receivers.positions.size(); i += stride) {
        if (!receivers.seen(i)) {
            continue;
        }
        Record r{};
        r.position = receivers.positions[i];
        r.normal = receivers.normals[i];
        r.tangent = tangentFrame(r.normal)[0];
        r.order = receivers.orders[i];
        r.radius = random.uniform(0.2f, 3.0f);
        r.irradiance = random.point(0.1f, 2.0f);
        r.rotation_r = random.point(-0.3f, 0.3f);
        r.rotation_b = random.point(-0.3f, 0.3f);
        r.translation_g = random.point(-0.3f, 0.3f);
        r.translation_b = random.point(-3.0f, 3.0f);  // steep: sums below zero are cut
        r.material = static_cast<float>(receivers.materials[i]);
        r.missed_r = missed.uniform(-0.5f, 0.5f);
        r.missed_g = missed.uniform(-0.5f, 0.5f);
        r.missed_b = missed.uniform(-0.5f, 0.5f);
        r.sh_first = static_cast<int>(cache.sh.size());
        if (r.order > shared::DIFFUSE_ORDER) {
            for (int k = 0; k < shLayout(r.order).size(); ++k) {
                cache.sh.push_back(random.uniform(-0.5f, 1.0f));
            }
        }
        cache.records.push_back(r);
    }
    return cache;
}

void expectSame(const Image<vec4>& gpu, const Image<vec4>& cpu, float scale, const char* what) {
    ASSERT_EQ(gpu.pixels.size(), cpu.pixels.size());
    for (size_t i = 0; i < gpu.pixels.size(); ++i) {
        for (int c = 0; c < 4; ++c) {
            ASSERT_TRUE(std::isfinite(gpu.pixels[i][c]));
            ASSERT_NEAR(gpu.pixels[i][c], cpu.pixels[i][c],
                        kSplatError * (std::abs(cpu.pixels[i][c]) + scale))
                << what << " pixel " << i << " channel " << c;
        }
    }
}

TEST(Splat, GpuEqualsCpuForEveryOrder) {
    const Scene scene = glossyRoom(0.5f, 0.4f);
    TestStage stage(scene);
    const GBuffer g = stage.gbuffer(72, 60);
    for (int order = 1; order <= shared::SH_MAX_ORDER; ++order) {
        const Receivers receivers = receiversOf(scene, g, order, false);
        ASSERT_GT(receivers.counts.diffuse, 100);
        ASSERT_GT(receivers.counts.seen - receivers.counts.diffuse, 100);
        const RecordCache cache = makeRecords(receivers, 13, static_cast<uint32_t>(order));
        const SplatBuffer gpu = splatGpu(stage.pool, receivers, cache, kWeight);
        const SplatBuffer cpu = splatCpu(receivers, cache, kWeight);
        SCOPED_TRACE("order " + std::to_string(order));
        // Weights reach a few hundred beside the records' own pixels.
        expectSame(gpu.irradiance, cpu.irradiance, 10.0f, "irradiance");
        expectSame(gpu.specular, cpu.specular, 10.0f, "specular");
        expectSame(gpu.missed, cpu.missed, 10.0f, "missed");
        double total = 0.0;
        for (const vec4& v : cpu.specular.pixels) {
            total += std::abs(v.x);
        }
        EXPECT_GT(total, 1.0);
    }
}

TEST(Splat, OrdersMayMix) {
    // By prediction each material has an order of its own; diffuse records lie beside glossy ones.
    const Scene scene = glossyRoom(0.7f, 0.5f);
    TestStage stage(scene);
    const Receivers receivers = receiversOf(scene, stage.gbuffer(64, 64), 0, false);
    const std::set<int> orders(receivers.orders.begin(), receivers.orders.end());
    ASSERT_EQ(orders.count(shared::DIFFUSE_ORDER), 1u);
    ASSERT_GE(std::distance(orders.upper_bound(shared::DIFFUSE_ORDER), orders.end()), 2);
    const RecordCache cache = makeRecords(receivers, 17, 5);
    const SplatBuffer gpu = splatGpu(stage.pool, receivers, cache, kWeight);
    const SplatBuffer cpu = splatCpu(receivers, cache, kWeight);
    expectSame(gpu.irradiance, cpu.irradiance, 10.0f, "irradiance");
    expectSame(gpu.specular, cpu.specular, 10.0f, "specular");
}

TEST(Splat, BumpsAreSeenByBoth) {
    const Scene scene = glossyRoom(0.5f, 0.4f);
    TestStage stage(scene);
    Receivers receivers = receiversOf(scene, stage.gbuffer(40, 37), 0, false);
    const RecordCache cache = makeRecords(receivers, 13, 7);
    const SplatBuffer smooth = splatCpu(receivers, cache, kWeight);
    Random random(8);
    for (const vec3& n : receivers.normals) {
        receivers.mapped_normals.push_back(glm::normalize(n + 0.5f * random.direction()));
    }
    const SplatBuffer cpu = splatCpu(receivers, cache, kWeight);
    for (const int rows : {37, 5}) {
        const SplatBuffer gpu =
            splatGpu(stage.pool, receivers, cache, kWeight, rows * receivers.image.width);
        expectSame(gpu.irradiance, cpu.irradiance, 10.0f, "irradiance");
    }
    int other = 0;
    for (size_t i = 0; i < cpu.irradiance.pixels.size(); ++i) {
        EXPECT_EQ(cpu.irradiance.pixels[i].w, smooth.irradiance.pixels[i].w) << "weights stay";
        other += cpu.irradiance.pixels[i] != smooth.irradiance.pixels[i] ? 1 : 0;
    }
    EXPECT_GT(other, 1000);
}

TEST(Splat, BandsOfRowsChangeNoBit) {
    const Scene scene = glossyRoom(0.5f, 0.4f);
    TestStage stage(scene);
    const Receivers receivers = receiversOf(scene, stage.gbuffer(40, 37), 0, false);
    ASSERT_FALSE(receivers.lobes.steps.empty());
    const RecordCache cache = makeRecords(receivers, 13, 7);
    const SplatBuffer whole = splatGpu(stage.pool, receivers, cache, kWeight);
    for (int rows : {1, 5, 36}) {
        const SplatBuffer bands =
            splatGpu(stage.pool, receivers, cache, kWeight, rows * receivers.image.width);
        EXPECT_EQ(bands.irradiance.pixels, whole.irradiance.pixels) << rows;
        EXPECT_EQ(bands.specular.pixels, whole.specular.pixels) << rows;
        EXPECT_EQ(bands.missed.pixels, whole.missed.pixels) << rows;
    }
}

TEST(Splat, HugeAndTinyRecords) {
    // Regions of influence that fill the image, hold the camera, or are smaller than a pixel.
    const Scene scene =
        cornellRoom(glossyParams(vec3(0.5f), 0.0f, 0.5f), diffuseParams(vec3(0.5f)));
    TestStage stage(scene);
    const Receivers receivers = receiversOf(scene, stage.gbuffer(48, 40), 4, false);
    for (float radius : {1e-6f, 1e-2f, 100.0f, 1e6f}) {
        RecordCache cache = makeRecords(receivers, 37, 6);
        for (Record& r : cache.records) {
            r.radius = radius;
            r.translation_g = r.translation_b = vec3(0.0f);
        }
        std::fill(cache.sh.begin(), cache.sh.end(), 0.25f);
        const SplatBuffer gpu = splatGpu(stage.pool, receivers, cache, kWeight);
        const SplatBuffer cpu = splatCpu(receivers, cache, kWeight);
        // A weight at a record's own pixel: reach over half a footprint.
        const float scale = std::max(10.0f, 0.1f * radius);
        expectSame(gpu.irradiance, cpu.irradiance, scale, "irradiance");
        expectSame(gpu.specular, cpu.specular, scale, "specular");
    }
}

TEST(Splat, LongSumsOfHugeWeightsKeepTheirMean) {
    // A record at every pixel, each of which reaches all others that face the same way: hundreds of
    // weights, a few of them thousands of times the rest. Single precision loses less than a part
    // in a thousand.
    constexpr float kSumError = 1e-3f;
    const Scene scene =
        cornellRoom(glossyParams(vec3(0.5f), 0.0f, 0.5f), diffuseParams(vec3(0.5f)));
    TestStage stage(scene);
    const Receivers receivers = receiversOf(scene, stage.gbuffer(40, 40), 4, true);
    RecordCache cache = makeRecords(receivers, 1, 7);
    ASSERT_GT(cache.records.size(), 1500u);
    const vec3 light(0.7f, 1e-3f, 4e4f);
    for (Record& r : cache.records) {
        r.radius = 1e4f;
        r.irradiance = light;
        r.rotation_r = r.rotation_g = r.rotation_b = vec3(0.0f);
        r.translation_r = r.translation_g = r.translation_b = vec3(0.0f);
    }
    for (const SplatBuffer& splat :
         {splatGpu(stage.pool, receivers, cache, kWeight), splatCpu(receivers, cache, kWeight)}) {
        float greatest = 0.0f;
        for (const vec4& sum : splat.irradiance.pixels) {
            ASSERT_GT(sum.w, 0.0f);
            greatest = std::max(greatest, sum.w);
            for (int c = 0; c < 3; ++c) {
                ASSERT_NEAR(sum[c] / sum.w, light[c], kSumError * light[c]);
            }
        }
        EXPECT_GT(greatest, 1e6f);
    }
}

TEST(Splat, NoRecordsNoPixelsNoGloss) {
    const Scene scene =
        cornellRoom(glossyParams(vec3(0.5f), 0.0f, 0.5f), diffuseParams(vec3(0.5f)));
    TestStage stage(scene);
    const GBuffer g = stage.gbuffer(16, 16);
    for (bool irradiance_only : {false, true}) {
        const Receivers receivers = receiversOf(scene, g, 4, irradiance_only);
        const SplatBuffer none = splatGpu(stage.pool, receivers, RecordCache{}, kWeight);
        for (const vec4& v : none.irradiance.pixels) {
            EXPECT_EQ(v, vec4(0.0f));
        }
    }
    // Records, but no pixel that sees anything.
    const Scene empty;
    TestStage empty_stage(empty);
    const Receivers nothing =
        receiversOf(empty, empty_stage.gbuffer(lookAt(vec3(0, 0, 1), vec3(0)), 8, 8), 4, false);
    RecordCache cache;
    Record r{};
    r.normal = vec3(0, 0, 1);
    r.tangent = vec3(1, 0, 0);
    r.radius = 100.0f;
    r.irradiance = vec3(1.0f);
    cache.records.push_back(r);
    const SplatBuffer splat = splatGpu(empty_stage.pool, nothing, cache, kWeight);
    for (const vec4& v : splat.irradiance.pixels) {
        EXPECT_EQ(v, vec4(0.0f));
    }
}

// ---- Compose ------------------------------------------------------------------------------------

struct Composed {
    Frame frame;
    ComposeCounts counts;
};

// A 4 x 1 image of a diffuse surface; the splat is given.
Composed composeFour(
    const std::array<vec4, 4>& irradiance, int order,
    const std::function<void(Receivers&)>& change = [](Receivers&) {}) {
    Receivers r;
    r.image = pixelGrid(lookAt(vec3(0, 1, 0), vec3(0)), 4, 1);
    r.positions.assign(4, vec3(0.0f));
    r.footprints.assign(4, 1.0f);
    r.normals.assign(4, vec3(0, 1, 0));
    r.roughness.assign(4, 1.0f);
    r.diffuse.assign(4, vec3(0.5f));
    r.f0.assign(4, vec3(0.0f));
    r.f90.assign(4, 0.0f);
    r.direct.assign(4, vec3(1, 2, 3));
    r.triangles.assign(4, 0u);
    r.materials.assign(4, 0);
    r.orders.assign(4, static_cast<int8_t>(order));
    r.by_rays.assign(4, 0);
    r.lobes = {.first = std::vector<int>(4, order > 0 ? 0 : -1),
               .steps = {0},
               .scale = std::vector<vec3>(4, vec3(1.0f))};
    change(r);
    SplatBuffer splat{Image<vec4>(4, 1), Image<vec4>(4, 1), {}};
    splat.irradiance.pixels.assign(irradiance.begin(), irradiance.end());
    if (order > 0) {
        splat.specular.pixels = splat.irradiance.pixels;
        splat.irradiance.pixels.assign(4, vec4(0, 0, 0, 1));
    }
    Composed composed;
    composed.counts = compose(r, splat, Image<vec3>(4, 1), true, composed.frame);
    return composed;
}

TEST(Compose, DividesByTheWeights) {
    const Composed c = composeFour(
        {vec4(2, 4, 6, 2), vec4(1e-3f, 0, 0, 1e-3f), vec4(1e8f, 0, 0, 1e8f), vec4(0)}, 0);
    EXPECT_NEAR(c.frame.indirect.at(0, 0).z, 0.5f / kPi * 3.0f, 1e-6f);
    EXPECT_NEAR(c.frame.indirect.at(1, 0).x, 0.5f / kPi, 1e-6f);
    EXPECT_NEAR(c.frame.indirect.at(2, 0).x, 0.5f / kPi, 1e-6f);
    EXPECT_EQ(c.frame.indirect.at(3, 0), vec3(0.0f));  // no record
    EXPECT_EQ(c.frame.weight.at(0, 0), 2.0f);
    EXPECT_EQ(c.frame.direct.at(3, 0), vec3(1, 2, 3));
    EXPECT_EQ(c.counts.nonfinite, 0);
    EXPECT_EQ(c.counts.negative, 0);
}

TEST(Compose, CountsAndMendsWhatIsNotFinite) {
    const float nan = std::nanf("");
    for (int order : {0, 3}) {
        const Composed c = composeFour({vec4(nan, 1, 1, 1), vec4(kInfinity, 1, 1, 1),
                                        vec4(1, 1, -kInfinity, 1), vec4(1, 1, 1, 1)},
                                       order);
        EXPECT_EQ(c.counts.nonfinite, 3) << order;
        for (int x = 0; x < 4; ++x) {
            const vec3 v = c.frame.indirect.at(x, 0) + c.frame.indirect_diffuse.at(x, 0);
            EXPECT_TRUE(std::isfinite(v.x + v.y + v.z)) << order;
        }
        EXPECT_EQ(c.frame.indirect.at(0, 0), vec3(0.0f));
        EXPECT_GT(c.frame.indirect.at(3, 0).x, 0.0f);
    }
}

TEST(Compose, DirectLightThatIsNotFiniteIsMendedToo) {
    const vec4 sound(1, 1, 1, 1);
    const Composed c = composeFour({sound, sound, sound, sound}, 0, [](Receivers& r) {
        r.direct[1].y = kInfinity;
        r.direct[2].x = 3.0f;
    });
    EXPECT_EQ(c.counts.nonfinite, 1);
    EXPECT_EQ(c.frame.direct.at(1, 0), vec3(0.0f));
    EXPECT_EQ(c.frame.direct.at(2, 0).x, 3.0f);
    EXPECT_GT(c.frame.indirect.at(1, 0).x, 0.0f);
}

TEST(Compose, CountsAndClampsWhatIsNegative) {
    const Composed c = composeFour(
        {vec4(-1, 1, 1, 1), vec4(1, 1, 1, 1), vec4(-1, -1, -1, 1), vec4(0, 0, 0, 1)}, 3);
    EXPECT_EQ(c.counts.negative, 2);
    for (int x = 0; x < 4; ++x) {
        EXPECT_GE(glm::min(glm::min(c.frame.indirect.at(x, 0).x, c.frame.indirect.at(x, 0).y),
                           c.frame.indirect.at(x, 0).z),
                  0.0f);
    }
    EXPECT_EQ(c.frame.indirect.at(0, 0), vec3(0, 1, 1));  // only the channel that is negative
}

}  // namespace
}  // namespace sheen
