// Many punctual lights, what lamps bring without shadows, and what cells keep of both.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/directions.h"
#include "light/direct.h"
#include "light/punctual.h"
#include "raster/gbuffer.h"
#include "test_light.h"
#include "test_reference.h"

namespace sheen {
namespace {

SurfaceSide sideSeenFromAbove(const vec3& p, const vec3& n) {
    return {.position = p, .n_g = n, .toward_viewer = n, .offset = 1e-7f};
}

PunctualLight lightAt(const vec3& p, float intensity) {
    PunctualLight light{};
    light.position = p;
    light.direction = -kUp;
    light.intensity = vec3(intensity);
    light.spot_offset = 1.0f;
    light.kind = shared::LIGHT_POINT;
    light.cos_outer = -1.0f;
    return light;
}

// So many lights over the plane y = 0, of intensities that differ, every third one a spot.
Scene underLights(int count) {
    Scene scene;
    addQuad(scene, vec3(-4, 0, 4), vec3(8, 0, 0), vec3(0, 0, -8),
            addMaterial(scene, diffuseParams(vec3(0.8f))));
    for (int i = 0; i < count; ++i) {
        const auto k = static_cast<uint32_t>(i);
        const vec2 place = randomPlace(k, 0);
        PunctualLight light = lightAt({8 * place.x - 4, 1 + randomPlace(k, 1).x, 8 * place.y - 4},
                                      1.0f + static_cast<float>(i % 5));
        if (i % 3 == 0) {
            light.kind = shared::LIGHT_SPOT;
            light.direction = glm::normalize(vec3(randomPlace(k, 2).x - 0.5f, -1, 0.3f));
            light.cos_outer = 0.6f;
            light.spot_scale = 1.0f / 0.2f;
            light.spot_offset = -0.6f / 0.2f;
        }
        scene.lights.push_back(light);
    }
    return scene;
}

float irradianceOf(const Scene& scene, const vec3& p, const vec3& n) {
    float sum = 0.0f;
    for (const PunctualLight& light : scene.lights) {
        const LightSample s = shared::sampleLight(light, p);
        sum += s.irradiance.x * std::max(glm::dot(n, s.wi), 0.0f);
    }
    return sum;
}

// A box of side 2 with a lamp under its ceiling and something that hides a part of it.
Scene roomWithALamp() {
    Scene scene;
    const uint32_t white = addMaterial(scene, diffuseParams(vec3(0.7f)));
    addBox(scene, vec3(-1), vec3(1), {white, white, white, white, white, white}, true);
    addBox(scene, vec3(-0.3f), vec3(0.1f), white, false);
    addQuad(scene, vec3(-0.3f, 0.9f, -0.3f), vec3(0.6f, 0, 0), vec3(0, 0, 0.6f),
            addMaterial(scene, diffuseParams(vec3(0.0f), vec3(5.0f))));
    return scene;
}

TEST(ManyLights, FewAreAskedOneByOne) {
    Scene scene = underLights(static_cast<int>(ManyLights::kFew));
    EXPECT_EQ(ManyLights(scene).each().size(), ManyLights::kFew);
    EXPECT_TRUE(ManyLights(scene).empty());
    PunctualLight sun = lightAt(vec3(0.0f), 1.0f);
    sun.kind = shared::LIGHT_DIRECTIONAL;
    scene.lights.push_back(sun);
    EXPECT_TRUE(ManyLights(scene).empty());  // a sun needs no place in the tree
    scene.lights.push_back(lightAt(kUp, 1.0f));
    EXPECT_FALSE(ManyLights(scene).empty());
    ASSERT_EQ(ManyLights(scene).each().size(), 1u);
    EXPECT_EQ(ManyLights(scene).each()[0].kind, shared::LIGHT_DIRECTIONAL);
}

// As many parts as lights: none is left to chance, none is missing.
TEST(ManyLights, PartsOfOneLightEachAddUpExactly) {
    const Scene scene = underLights(static_cast<int>(ManyLights::kParts));
    const ManyLights lights(scene);
    for (const vec3& p : {vec3(0, 0, 0), vec3(-3, 0, 2), vec3(3.9f, 0.5f, -3.9f)}) {
        float sum = 0.0f;
        lights.forEachPart(sideSeenFromAbove(p, kUp), kUp, ManyLights::kParts, 1,
                           [&](const ManyLights::Sample& s) {
                               sum += s.light.irradiance.x * glm::dot(s.light.wi, kUp);
                           });
        const float expected = irradianceOf(scene, p, kUp);
        EXPECT_NEAR(sum, expected, 1e-4f * expected);
    }
}

TEST(ManyLights, PartsAndSamplesOfManyAddUpOnAverage) {
    const Scene scene = underLights(500);
    const ManyLights lights(scene);
    const vec3 p(0.5f, 0.0f, -0.3f);
    constexpr uint32_t kDraws = 400, kSamples = 1 << 15;
    double parts = 0.0, squares = 0.0;
    for (uint32_t draw = 0; draw < kDraws; ++draw) {
        double sum = 0.0;
        lights.forEachPart(sideSeenFromAbove(p, kUp), kUp, ManyLights::kParts, draw,
                           [&](const ManyLights::Sample& s) {
                               sum += s.light.irradiance.x * glm::dot(s.light.wi, kUp);
                           });
        parts += sum;
        squares += sum * sum;
    }
    const double expected = irradianceOf(scene, p, kUp);
    const double mean = parts / kDraws;
    EXPECT_NEAR(mean, expected, 0.003 * expected);
    EXPECT_LT(std::sqrt(squares / kDraws - mean * mean), 0.03 * expected);
    double samples = 0.0;
    for (uint32_t i = 0; i < kSamples; ++i) {
        if (const auto s = lights.sample(sideSeenFromAbove(p, kUp), kUp, randomPlace(i, 0).x)) {
            samples += s->light.irradiance.x * glm::dot(s->light.wi, kUp);
        }
    }
    EXPECT_NEAR(samples / kSamples, expected, 0.02 * expected);
}

TEST(ManyLights, NothingShinesFromBehind) {
    const Scene scene = underLights(40);
    const ManyLights lights(scene);
    lights.forEachPart(sideSeenFromAbove(vec3(0.0f), -kUp), -kUp, ManyLights::kParts, 1,
                       [](const ManyLights::Sample&) { ADD_FAILURE(); });
    EXPECT_FALSE(lights.sample(sideSeenFromAbove(vec3(0.0f), -kUp), -kUp, 0.3f));
}

// Pixels of a box among 60 lights, and what rays meet there: by chance as one by one.
TEST(ManyLights, LightTheImageAsOneByOne) {
    Scene scene = underLights(60);
    addBox(scene, vec3(-1, 0, -1), vec3(1, 0.5f, 1),
           addMaterial(scene, glossyParams(vec3(0.5f), 0.0f, 0.4f)), false);
    scene.cameras = {lookAt(vec3(3, 3, 5), vec3(0.0f))};
    const Tracer tracer(scene);
    const SceneLights lights(tracer);
    const GBuffer gbuffer = renderGBuffer(tracer, scene.cameras[0], 32, 32);
    const Image<vec3> direct = traceDirect(tracer, lights, gbuffer);
    const ScatteredOnce by_chance(tracer, &lights, {}), one_by_one(tracer);
    double difference = 0.0, all = 0.0;
    double chance = 0.0, exact = 0.0;
    std::vector<vec3> directions;
    std::vector<float> angles;
    for (int i = 0; i < 2048; ++i) {
        const vec3 d = cosineDirection(randomPlace(7, static_cast<uint32_t>(i)));
        directions.push_back(vec3(d.x, -d.z, d.y));
        angles.push_back(kPi / 2048);
    }
    const Rays rays{
        .origin = vec3(0.2f, 2, 0.1f), .directions = directions, .solid_angles = angles};
    std::vector<vec4> seen(directions.size()), known(directions.size());
    by_chance.cast(rays, seen.data());
    one_by_one.cast(rays, known.data());
    for (size_t i = 0; i < seen.size(); ++i) {
        chance += seen[i].x;
        exact += known[i].x;
    }
    EXPECT_NEAR(chance, exact, 0.01 * exact);
    for (size_t i = 0; i < direct.pixels.size(); ++i) {
        if (!gbuffer.seen(i)) {
            continue;
        }
        const SurfaceSide side = gbuffer.sideAt(scene, i);
        const Scatterer surface{
            .n = gbuffer.mappedNormalAt(i),
            .brdf = {.diffuse = gbuffer.diffuse.pixels[i],
                     .alpha = shared::alphaFromRoughness(gbuffer.roughness.pixels[i]),
                     .f0 = gbuffer.f0.pixels[i],
                     .f90 = gbuffer.f90.pixels[i]}};
        double sum = 0.0;
        for (const PunctualLight& light : scene.lights) {
            if (reaching(tracer, light, {&side, 1})[0] != vec3(0.0f)) {
                sum += scattered(surface, side.toward_viewer,
                                 shared::sampleLight(light, side.position))
                           .x;
            }
        }
        difference += (direct.pixels[i].x - sum) * (direct.pixels[i].x - sum);
        all += sum * sum;
    }
    EXPECT_GT(all, 0.0);
    EXPECT_LT(std::sqrt(difference / all), 0.01);
}

// More lights than parts, at pixels and at the samples of pixels: nothing is lost.
TEST(ManyLights, PixelsOfMoreLightsThanPartsHaveTheirMean) {
    Scene scene = underLights(700);
    scene.cameras = {lookAt(vec3(0, 5, 0.1f), vec3(0.0f))};
    const Tracer tracer(scene);
    const SceneLights lights(tracer);
    const GBuffer gbuffer = renderGBuffer(tracer, scene.cameras[0], 32, 32);
    std::vector<uint32_t> rows(32);
    std::iota(rows.begin(), rows.end(), 0u);
    double expected = 0.0;
    for (size_t i = 0; i < gbuffer.diffuse.pixels.size(); ++i) {
        if (gbuffer.seen(i)) {
            expected += irradianceOf(scene, gbuffer.sideAt(scene, i).position, kUp) * 0.8f / kPi;
        }
    }
    for (const std::span<const uint32_t> rows_of : {std::span<const uint32_t>(), {rows}}) {
        double sum = 0.0;
        for (const vec3& pixel : traceDirect(tracer, lights, gbuffer, rows_of).pixels) {
            sum += pixel.x;
        }
        EXPECT_NEAR(sum, expected, 0.01 * expected);
    }
}

TEST(Lamps, IrradianceOfAnOpenSquareIsItsFormFactor) {
    const vec3 radiance(4, 2, 1);
    for (const float h : {0.01f, 0.5f, 3.0f}) {
        Scene scene;
        addQuad(scene, vec3(-h, 1, -h), vec3(2 * h, 0, 0), vec3(0, 0, 2 * h),
                addMaterial(scene, diffuseParams(vec3(0.0f), radiance)));
        const Tracer tracer(scene);
        const LampSampler lamps(tracer);
        ASSERT_TRUE(lamps.plain());
        const double r = std::sqrt(1.0 + double{h} * h);
        const double up = 4.0 * h / r * std::atan(h / r);  // [HSM10, B-3]
        EXPECT_NEAR(lamps.irradiance(sideSeenFromAbove(vec3(0.0f), kUp), kUp).x, radiance.x * up,
                    1e-3 * radiance.x * up)
            << h;
        // Of a normal that lies flat half of it is below the horizon. [HSM10, B-5, doubled]
        const vec3 flat(1, 0, 0);
        const double aside = std::atan(h) - std::atan(h / r) / r;
        EXPECT_NEAR(lamps.irradiance(sideSeenFromAbove(vec3(0.0f), flat), flat).y,
                    radiance.y * aside, 2e-3 * radiance.y * aside)
            << h;
        EXPECT_EQ(lamps.irradiance(sideSeenFromAbove(vec3(0.0f), -kUp), -kUp), vec3(0.0f));
    }
}

// No lamp is hidden: what arrives is known, and no pixel has noise, not even in the blue of a lamp
// so weak that samples seldom meet it.
TEST(Lamps, OpenLightHasNoNoise) {
    Scene scene;
    addQuad(scene, vec3(-2, 0, 2), vec3(4, 0, 0), vec3(0, 0, -4),
            addMaterial(scene, diffuseParams(vec3(0.5f))));
    addQuad(scene, vec3(-1, 2, -1), vec3(2, 0, 0), vec3(0, 0, 2),
            addMaterial(scene, diffuseParams(vec3(0.0f), vec3(3.0f, 1.0f, 0.0f))));
    addQuad(scene, vec3(-1.9f, 1, -1), vec3(0.2f, 0, 0), vec3(0, 0, 0.2f),
            addMaterial(scene, diffuseParams(vec3(0.0f), vec3(0.0f, 0.0f, 2.0f))));
    scene.cameras = {lookAt(vec3(0, 1.5f, 3), vec3(0.0f))};
    const Tracer tracer(scene);
    const SceneLights lights(tracer);
    const GBuffer gbuffer = renderGBuffer(tracer, scene.cameras[0], 24, 24);
    const Image<vec3> direct = traceDirect(tracer, lights, gbuffer);
    int compared = 0;
    for (size_t i = 0; i < direct.pixels.size(); ++i) {
        if (gbuffer.seen(i) && gbuffer.diffuse.pixels[i].x > 0.0f) {
            const vec3 expected =
                lights.lamps.irradiance(gbuffer.sideAt(scene, i), kUp) * 0.5f / kPi;
            for (int c = 0; c < 3; ++c) {
                EXPECT_NEAR(direct.pixels[i][c], expected[c], 1e-4f * expected[c]);
            }
            ++compared;
        }
    }
    EXPECT_GT(compared, 100);
}

// A white sky over a plane: what rays meet sends on its albedo, by cells and without them.
TEST(ScatteredOnce, CellsKeepTheSkysLight) {
    Scene scene;
    addQuad(scene, vec3(-1, 0, 1), vec3(2, 0, 0), vec3(0, 0, -2),
            addMaterial(scene, diffuseParams(vec3(0.25f, 0.5f, 0.75f))));
    scene.environment.texels = Image<vec3>(1, 1, vec3(2.0f));
    const Tracer tracer(scene);
    const SceneLights lights(tracer);
    const ScatteredOnce light(tracer, &lights, {});
    const vec3 down = -kUp;
    const float angle = 0.01f;
    for (const std::span<const float> angles : {std::span<const float>(), {&angle, 1}}) {
        vec4 seen;
        light.cast(
            {.origin = vec3(0.1f, 1, 0.2f), .directions = {&down, 1}, .solid_angles = angles},
            &seen);
        EXPECT_NEAR(seen.x, 0.5f, 1e-3f);
        EXPECT_NEAR(seen.y, 1.0f, 1e-3f);
        EXPECT_NEAR(seen.z, 1.5f, 1e-3f);
    }
}

// Whichever ray asks a cell first, from near or from afar, all are told the same.
TEST(ScatteredOnce, CellsSayTheSameWhicheverRayAsksFirst) {
    const Scene scene = roomWithALamp();
    const Tracer tracer(scene);
    const SceneLights lights(tracer);
    const vec3 ways[] = {glm::normalize(vec3(-0.3f, -1, -0.1f)), -kUp};
    vec4 first[2], last[2];
    for (const bool turned : {false, true}) {
        const ScatteredOnce light(tracer, &lights, {});
        vec4* seen = turned ? last : first;
        for (int i = 0; i < 2; ++i) {
            const int k = turned ? 1 - i : i;
            // Both meet the floor in one point.
            const vec3 origin = vec3(0.101f, -1, 0.203f) - (k == 0 ? 1.7f : 0.4f) * ways[k];
            const float angle = 0.02f;
            light.cast({.origin = origin, .directions = {&ways[k], 1}, .solid_angles = {&angle, 1}},
                       &seen[k]);
        }
    }
    for (int k = 0; k < 2; ++k) {
        EXPECT_EQ(first[k], last[k]);
        EXPECT_GT(first[k].x, 0.0f);
    }
    EXPECT_EQ(first[0].x, first[1].x) << "of one cell";
}

}  // namespace
}  // namespace sheen
