// Lamps and the sky: what samples add up to, against closed forms and the reference.
#include <gtest/gtest.h>

#include <cmath>
#include <utility>
#include <vector>

#include "core/directions.h"
#include "light/direct.h"
#include "light/light_tree.h"
#include "light/sky.h"
#include "rays/jitter.h"
#include "test_light.h"
#include "test_reference.h"

namespace sheen {
namespace {

const vec3 kRadiance(4, 2, 1);

// A square lamp of side 2 h at height 1 above the origin, and what else there is.
Scene underSquare(float h) {
    Scene scene;
    const uint32_t lamp = addMaterial(scene, diffuseParams(vec3(0.0f), kRadiance));
    addQuad(scene, vec3(-h, 1, -h), vec3(2 * h, 0, 0), vec3(0, 0, 2 * h), lamp);
    return scene;
}

// What it sends to the origin, over its radiance. [HSM10, B-3]
double irradianceOfSquare(double h) {
    const double r = std::sqrt(1.0 + h * h);
    return 4.0 * 2.0 * 0.5 * h / r * std::atan(h / r);
}

SurfaceSide sideAt(const vec3& p, const vec3& n) {
    return {.position = p, .n_g = n, .toward_viewer = vec3(0.0f), .offset = 1e-5f};
}

vec3 numbers(int i) {
    const auto k = static_cast<uint32_t>(i);
    return {randomPlace(k, 0), randomPlace(k, 1).x};
}

TEST(Lamps, SamplesAddUpToTheIrradianceOfASquare) {
    constexpr int kCount = 1 << 16;
    for (const float h : {0.01f, 0.5f, 3.0f}) {
        const Scene scene = underSquare(h);
        const Tracer tracer(scene);
        const LampSampler lamps(tracer);
        const SurfaceSide origin = sideAt(vec3(0.0f), kUp);
        vec3 sum(0.0f);
        double angle = 0.0;
        for (int i = 0; i < kCount; ++i) {
            if (const auto s = lamps.sample(origin, kUp, numbers(i))) {
                EXPECT_EQ(s->radiance, kRadiance);
                sum += s->radiance * s->wi.y / s->density;
                angle += 1.0 / s->density;
            }
        }
        const double expected = irradianceOfSquare(h);
        EXPECT_NEAR(sum.x / kCount, kRadiance.x * expected, 0.01 * kRadiance.x * expected) << h;
        const double h2 = h * h;
        const double solid_angle = 4.0 * std::asin(h2 / (1.0 + h2));
        EXPECT_NEAR(angle / kCount, solid_angle, 0.01 * solid_angle) << h;
    }
}

// Where a sample leads, a ray finds the lamp, and knows how often the sample comes there.
TEST(Lamps, RaysKnowTheDensityOfSamples) {
    Scene scene = underSquare(0.7f);
    addSphere(scene, vec3(1.5f, 0.8f, 0.2f), 0.2f, 12, 0);
    const Tracer tracer(scene);
    const LampSampler lamps(tracer);
    int compared = 0;
    for (int i = 0; i < 400; ++i) {
        const SurfaceSide from = sideAt(vec3(0.1f * static_cast<float>(i % 7), 0, 0), kUp);
        const auto s = lamps.sample(from, kUp, numbers(i));
        if (!s || tracer.passing({&s->way, 1})[0] == vec3(0.0f)) {
            continue;
        }
        Hit hit;
        tracer.meet({.origin = from.start(), .directions = {&s->wi, 1}}, &hit);
        ASSERT_TRUE(hit.found() && lamps.isLamp(hit.triangle));
        EXPECT_EQ(lamps.radiance(hit), kRadiance);
        EXPECT_NEAR(lamps.density(from, kUp, hit, s->wi), s->density, 0.02f * s->density);
        ++compared;
    }
    EXPECT_GT(compared, 200);
}

// A sphere of many triangles far away: nearly every sample sees it, and all say nearly the same.
TEST(Lamps, SamplesOfABulbHardlyDiffer) {
    Scene scene;
    const uint32_t lamp = addMaterial(scene, diffuseParams(vec3(0.0f), kRadiance));
    addSphere(scene, vec3(0, 2, 0), 0.04f, 12, lamp);
    const Tracer tracer(scene);
    const LampSampler lamps(tracer);
    constexpr int kCount = 4096;
    double sum = 0.0, squares = 0.0;
    for (int i = 0; i < kCount; ++i) {
        const auto s = lamps.sample(sideAt(vec3(0.0f), kUp), kUp, numbers(i));
        const bool free = s && tracer.passing({&s->way, 1})[0] != vec3(0.0f);
        const double light = free ? s->radiance.x * s->wi.y / s->density : 0.0;
        sum += light;
        squares += light * light;
    }
    const double mean = sum / kCount;
    const double disc = kPi * kRadiance.x * 0.02 * 0.02;  // its faces lie within the sphere
    EXPECT_NEAR(mean, disc, 0.06 * disc);
    EXPECT_LT(std::sqrt(squares / kCount - mean * mean), 0.45 * mean);
}

TEST(LightTree, ChoosesAsOftenAsItSaysAndNoLightBelowTheHorizon) {
    Random random(3);
    std::vector<LightBounds> lights(40);
    for (size_t i = 0; i < lights.size(); ++i) {
        const vec3 p = random.point(-1.0f, 1.0f);
        lights[i].box.add(p);
        lights[i].box.add(p + random.point(0.0f, 0.1f));
        const float power = i == 7 ? 0.0f : random.uniform(0.5f, 2.0f);
        lights[i].intensity = i % 2 == 0 ? Intensity::everywhere(power)
                                         : Intensity::byCosine(random.direction(kUp), power);
    }
    const LightTree tree(lights);
    const vec3 p(0.2f, 0.1f, -0.3f);
    double all = 0.0;
    std::vector<double> probabilities;
    for (uint32_t i = 0; i < lights.size(); ++i) {
        if (i != 7) {  // the tree does not know it
            probabilities.push_back(tree.probability(p, kUp, i));
            all += probabilities.back();
        } else {
            probabilities.push_back(0.0);
        }
        if (lights[i].box.upper.y < p.y) {
            EXPECT_EQ(probabilities.back(), 0.0) << i;
        }
    }
    // What is left leads to lights below the horizon.
    EXPECT_LE(all, 1.0 + 1e-4);
    EXPECT_GT(all, 0.5);
    constexpr int kCount = 1 << 16;
    std::vector<int> chosen(lights.size());
    int none = 0;
    for (int i = 0; i < kCount; ++i) {
        const auto choice =
            tree.choose(p, kUp, (static_cast<float>(i) + 0.5f) / static_cast<float>(kCount));
        none += choice ? 0 : 1;
        if (!choice) {
            continue;
        }
        EXPECT_NEAR(choice->probability, probabilities[choice->light], 1e-5);
        EXPECT_GE(choice->u, 0.0f);
        EXPECT_LT(choice->u, 1.0f);
        ++chosen[choice->light];
    }
    for (size_t i = 0; i < lights.size(); ++i) {
        EXPECT_NEAR(chosen[i], probabilities[i] * kCount, 4.0) << i;
    }
    EXPECT_NEAR(none, (1.0 - all) * kCount, 40.0);
    EXPECT_FALSE(LightTree().choose(p, kUp, 0.5f));
}

// ---- What rays and pixels see -------------------------------------------------------------------

// The mean of what rays see of a floor by many points of it near the origin.
vec3 seenOfFloor(const Scene& scene, const OutgoingLight& light) {
    constexpr int kCount = 1 << 14;
    std::vector<vec3> directions;
    Random random(5);
    const vec3 eye(0.05f, 0.5f, 0.02f);
    for (int i = 0; i < kCount; ++i) {
        const vec3 target = random.point(-0.01f, 0.01f) * vec3(1, 0, 1);
        directions.push_back(glm::normalize(target - eye));
    }
    std::vector<vec4> seen(directions.size());
    light.cast({.origin = eye, .directions = directions}, seen.data());
    vec3 sum(0.0f);
    for (const vec4& s : seen) {
        sum += vec3(s);
    }
    EXPECT_EQ(&light.scene(), &scene);
    return sum / static_cast<float>(kCount);
}

TEST(ScatteredOnce, LampsLightWhatRaysMeetAndAreBlackThemselves) {
    const vec3 albedo(0.5f, 0.25f, 1.0f);
    Scene scene = underSquare(0.5f);
    addQuad(scene, vec3(-4, 0, 4), vec3(8, 0, 0), vec3(0, 0, -8),
            addMaterial(scene, diffuseParams(albedo)));
    const Tracer tracer(scene);
    const SceneLights lights(tracer);
    const ScatteredOnce light(tracer, &lights);
    const vec3 expected = albedo / kPi * kRadiance * static_cast<float>(irradianceOfSquare(0.5));
    const vec3 seen = seenOfFloor(scene, light);
    for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(seen[c], expected[c], 0.02f * expected[c]);
    }
    vec4 lamp;
    light.cast({.origin = vec3(0, 0.5f, 0), .directions = {&kUp, 1}}, &lamp);
    EXPECT_LT(lamp.x, 1e-6f);
    EXPECT_NEAR(lamp.w, 0.5f, 1e-5f);
}

// A mirror's pixel has few rays, which all meet nearly one point.
TEST(ScatteredOnce, RaysThatMeetOnePointSpreadTheirSamples) {
    Scene scene = underSquare(1.0f);
    addQuad(scene, vec3(-2, 0, -2), vec3(0, 0, 4), vec3(4, 0, 0),
            addMaterial(scene, diffuseParams(vec3(0.5f))));
    const Tracer tracer(scene);
    const SceneLights lights(tracer);
    const ScatteredOnce light(tracer, &lights);
    constexpr size_t kRays = 8;
    constexpr uint32_t kPoints = 256;
    const vec3 eye(0.2f, 0.3f, 0.1f);
    // Mean and variance of what `count` rays see on average, over points close to each other.
    const auto momentsOf = [&](size_t count) {
        double sum = 0.0, squares = 0.0;
        for (uint32_t i = 0; i < kPoints; ++i) {
            const vec2 at = 0.01f * randomPlace(i, 0);
            std::vector<vec3> directions;
            for (uint32_t k = 0; k < count; ++k) {
                const vec3 to = vec3(at.x, 0.0f, at.y) + 1e-5f * vec3(randomPlace(i, 1 + k), 0.0f);
                directions.push_back(glm::normalize(to - eye));
            }
            vec4 seen[kRays];
            light.cast({.origin = eye, .directions = directions}, seen);
            double mean = 0.0;
            for (size_t k = 0; k < count; ++k) {
                mean += seen[k].y / static_cast<double>(count);
            }
            sum += mean / kPoints;
            squares += mean * mean / kPoints;
        }
        return std::pair(sum, squares - sum * sum);
    };
    const auto [one, variance_of_one] = momentsOf(1);
    const auto [all, variance_of_all] = momentsOf(kRays);
    const double deviation = std::sqrt(variance_of_one / kPoints);
    EXPECT_NEAR(all, one, 4.0 * deviation);
    EXPECT_GT(deviation, 1e-3 * one);
    // Rays that know nothing of each other have an eighth.
    EXPECT_LT(variance_of_all, 0.6 * variance_of_one / kRays);
}

TEST(ScatteredOnce, TheSkyLightsWhatRaysMeetAndIsSeenPastIt) {
    const vec3 albedo(0.5f, 0.25f, 1.0f);
    const vec3 blue(0.5f, 1.0f, 2.0f);
    for (const bool image : {false, true}) {
        Scene scene;
        addQuad(scene, vec3(-4, 0, 4), vec3(8, 0, 0), vec3(0, 0, -8),
                addMaterial(scene, diffuseParams(albedo)));
        scene.environment.texels = image ? Image<vec3>(16, 8, blue) : Image<vec3>(1, 1, blue);
        const Tracer tracer(scene);
        const ScatteredOnce light(tracer);
        const vec3 seen = seenOfFloor(scene, light);
        for (int c = 0; c < 3; ++c) {
            EXPECT_NEAR(seen[c], albedo[c] * blue[c], 0.02f * albedo[c] * blue[c]) << image;
        }
        vec4 sky;
        light.cast({.origin = vec3(0, 0.5f, 0), .directions = {&kUp, 1}}, &sky);
        EXPECT_EQ(sky, vec4(blue, 0.0f));
    }
}

// A sky whose rows and columns differ: the mean of radiance over density is the whole sky's light.
TEST(SkySampler, SamplesAddUpToTheLightOfTheWholeSky) {
    Environment environment;
    environment.texels = Image<vec3>(24, 12);
    double expected = 0.0;
    constexpr int kSteps = 1200;
    for (int y = 0; y < 12; ++y) {
        for (int x = 0; x < 24; ++x) {
            environment.texels.at(x, y) = vec3((x == 5 && y == 3) ? 50.0f : x < 8 ? 0.0f : 1.0f);
        }
    }
    for (int j = 0; j < kSteps; ++j) {
        for (int i = 0; i < kSteps; ++i) {
            const vec2 uv = (vec2(i, j) + 0.5f) / static_cast<float>(kSteps);
            expected += environment.radiance(environment.directionFromImage(uv)).x *
                        std::sin(kPi * uv.y) * 2.0 * kPi * kPi / (kSteps * kSteps);
        }
    }
    const SkySampler sky(environment);
    constexpr int kCount = 1 << 16;
    double sum = 0.0;
    for (int i = 0; i < kCount; ++i) {
        const SkySampler::Sample s = sky.sample(kUp, vec2(numbers(i)));
        EXPECT_NEAR(glm::length(s.wi), 1.0f, 1e-5f);
        sum += s.density > 0.0f ? s.radiance.x / s.density : 0.0;
    }
    EXPECT_NEAR(sum / kCount, expected, 0.01 * expected);
}

// A lamp and its shade over a floor, rough or polished: penumbrae, and the lamp's image in the
// floor. Root mean square of green over its mean, the reference's noise taken off.
TEST(TracedDirect, OfLampsIsTheReferences) {
    constexpr int kSize = 48;
    constexpr double kNoise = 0.02;
    for (const float roughness : {1.0f, 0.3f, 0.1f}) {
        Scene scene = underSquare(0.3f);
        MaterialParams floor = diffuseParams(vec3(0.5f));
        floor.specular = 1.0f;
        floor.roughness = roughness;
        addQuad(scene, vec3(-4, 0, 4), vec3(8, 0, 0), vec3(0, 0, -8), addMaterial(scene, floor));
        addQuad(scene, vec3(0.1f, 0.6f, -0.2f), vec3(0.3f, 0, 0), vec3(0, 0, 0.4f),
                addMaterial(scene, diffuseParams(vec3(0.2f))));
        scene.cameras.push_back(lookAt(vec3(0.0f, 0.5f, 2.5f), vec3(0.0f, 0.1f, 0.0f)));
        const Tracer tracer(scene);
        const GBuffer gbuffer = renderGBuffer(tracer, scene.cameras[0], kSize, kSize);
        const Image<vec3> direct = traceDirect(tracer, SceneLights(tracer), gbuffer);
        const ReferenceResult truth = renderReference(scene, {.width = kSize,
                                                              .height = kSize,
                                                              .camera = scene.cameras[0],
                                                              .bounces = 1,
                                                              .spp = 4096,
                                                              .replicates = 16,
                                                              .quiet = true});
        double squares = 0.0, mean = 0.0;
        for (size_t i = 0; i < direct.pixels.size(); ++i) {
            const double expected = truth.frame.direct.pixels[i].y;
            const double off = direct.pixels[i].y - expected;
            squares += off * off - truth.frame.direct_variance.pixels[i].y;
            mean += expected;
        }
        const auto count = static_cast<double>(direct.pixels.size());
        EXPECT_GT(mean, 0.0);
        EXPECT_LT(std::sqrt(squares / count), kNoise * mean / count) << "roughness " << roughness;
    }
}

}  // namespace
}  // namespace sheen
