// Radiance hints against closed forms, in hostile scenes, and from frame to frame.
#include "hints/hints.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numeric>

#include "core/parallel.h"
#include "test_scenes.h"

namespace sheen {
namespace {

constexpr HintsParams kFew{.hints = 1000, .samples = 512};

// Points of surfaces, seen from `height` above along their normals.
Receivers receiversAt(const std::vector<vec3>& positions, const std::vector<vec3>& normals,
                      const std::vector<uint32_t>& triangles, float height) {
    Receivers receivers;
    receivers.positions = positions;
    receivers.normals = normals;
    receivers.outward = normals;
    receivers.triangles = triangles;
    const size_t count = positions.size();
    receivers.footprints.assign(count, height);
    receivers.diffuse.assign(count, vec3(0.5f));
    receivers.f0.assign(count, vec3(0.0f));
    receivers.f90.assign(count, 0.0f);
    receivers.roughness.assign(count, 1.0f);
    return receivers;
}

// What rays from `eye` meet, a ring of directions at several heights.
Receivers seenFrom(const Tracer& tracer, const vec3& eye, uint32_t count = 256) {
    std::vector<vec3> positions, normals;
    std::vector<uint32_t> triangles;
    for (uint32_t i = 0; i < count; ++i) {
        const float z = 1.0f - (2.0f * static_cast<float>(i) + 1.0f) / static_cast<float>(count);
        const float phi = 2.4f * static_cast<float>(i);
        const float r = std::sqrt(1.0f - z * z);
        const vec3 d(r * std::cos(phi), z, r * std::sin(phi));
        Hit hit;
        tracer.meet({.origin = eye, .directions = {&d, 1}}, &hit);
        if (hit.found()) {
            const SurfacePoint p =
                surfacePoint(tracer.scene(), hit.triangle, hit.u, hit.v, -d, hit.distance);
            positions.push_back(p.position);
            normals.push_back(p.n_g);
            triangles.push_back(hit.triangle);
        }
    }
    return receiversAt(positions, normals, triangles, 1e-3f * tracer.scene().bounds.size());
}

// A scene and its hints, filled.
struct Hinted {
    Tracer tracer;
    SceneLights lights;
    RadianceHints hints;

    explicit Hinted(const Scene& scene, const HintsParams& params = kFew,
                    const std::vector<Bounds>& near = {})
        : tracer(scene), lights(tracer), hints(tracer, params, near) {
        hints.fill(lights);
    }
};

double mean(const std::vector<vec3>& light) {
    double sum = 0.0;
    for (const vec3& l : light) {
        sum += luminance(l);
    }
    return sum / static_cast<double>(std::max<size_t>(light.size(), 1));
}

// Root mean square of the difference over the mean of b.
double difference(const std::vector<vec3>& a, const std::vector<vec3>& b) {
    EXPECT_EQ(a.size(), b.size());
    double sum = 0.0;
    for (size_t i = 0; i < a.size(); ++i) {
        const double d = luminance(a[i]) - luminance(b[i]);
        sum += d * d;
    }
    return std::sqrt(sum / static_cast<double>(a.size())) / mean(b);
}

Scene sphereRoom(float albedo) {
    Scene scene;
    addSphere(scene, vec3(0.0f), 2.0f, 32, addMaterial(scene, diffuseParams(vec3(albedo))));
    scene.lights.push_back(pointLight(vec3(0.0f), vec3(4.0f)));
    return scene;
}

TEST(HintLightNumbers, irradianceIsExactAlongAxesAndCloseBetween) {
    for (const int order : {2, 3}) {
        float numbers[kMostHintNumbers] = {};
        const vec3 directions[] = {glm::normalize(vec3(1, 2, -1)), glm::normalize(vec3(-3, 1, 1)),
                                   vec3(0, 0, -1)};
        for (const vec3& d : directions) {
            addHintLight(d, vec3(1, 2, 3), order, numbers);
        }
        keepMissed(order, numbers);
        const auto exact = [&](const vec3& n) {
            float sum = 0.0f;
            for (const vec3& d : directions) {
                sum += std::max(glm::dot(d, n), 0.0f);
            }
            return sum;
        };
        for (const vec3& n : {vec3(1, 0, 0), vec3(-1, 0, 0), vec3(0, 1, 0), vec3(0, -1, 0),
                              vec3(0, 0, 1), vec3(0, 0, -1)}) {
            const vec3 found = hintIrradiance(numbers, n, order);
            EXPECT_NEAR(found.x, exact(n), 1e-5f);
            EXPECT_NEAR(found.z, 3.0f * exact(n), 3e-5f);
        }
        const vec3 n = glm::normalize(vec3(1, 1, -1));
        // Three directions are as far from smooth light as it comes.
        const float tolerance = order == 2 ? 0.25f : 0.15f;
        EXPECT_NEAR(hintIrradiance(numbers, n, order).x, exact(n), tolerance * exact(n));
    }
}

TEST(HintLightNumbers, constantLightIsSeenThroughAnyLobe) {
    constexpr int kCount = 4096;
    for (const int order : {2, 3}) {
        float numbers[kMostHintNumbers] = {};
        for (int i = 0; i < kCount; ++i) {
            const float z = 1.0f - (2.0f * static_cast<float>(i) + 1.0f) / kCount;
            const float r = std::sqrt(1.0f - z * z);
            const float phi = 2.39996323f * static_cast<float>(i);
            addHintLight(vec3(r * std::cos(phi), r * std::sin(phi), z), vec3(4.0f * kPi / kCount),
                         order, numbers);
        }
        keepMissed(order, numbers);
        EXPECT_NEAR(hintIrradiance(numbers, vec3(0, 1, 0), order).x, kPi, 1e-2f);
        const BrdfRotator rotator(order);
        for (const float roughness : {0.05f, 0.5f, 1.0f}) {
            float lobe[9];
            rotator.rotate(brdfSh(0.6f, roughness), 0.3f, 1.0f, vec3(0, 0, 1), vec3(0.8f, 0, 0.6f),
                           lobe);
            EXPECT_NEAR(hintThroughLobe(numbers, lobe, order).x, 1.0f, 1e-2f) << roughness;
        }
    }
}

// Of any lobe, light from one direction is never negative.
TEST(HintLightNumbers, lobesDoNotRing) {
    const BrdfRotator rotator(3);
    float lobe[9];
    rotator.rotate(brdfSh(0.6f, 0.1f), 1.0f, 1.0f, vec3(0, 0, 1), vec3(0.8f, 0, 0.6f), lobe);
    const vec3 mirrored(-0.8f, 0, 0.6f);
    float toward = 0.0f, away = 0.0f;
    for (const float sign : {1.0f, -1.0f}) {
        float numbers[kMostHintNumbers] = {};
        addHintLight(sign * mirrored, vec3(1.0f), 3, numbers);
        (sign > 0.0f ? toward : away) = hintThroughLobe(numbers, lobe, 3).x;
    }
    EXPECT_GT(toward, 0.2f);
    EXPECT_LT(away, 0.1f * toward);
}

TEST(HintLattice, ofBoxesAndOfPartsShareCells) {
    const Bounds room{.lower = vec3(-1, 0, 2), .upper = vec3(3, 2, 4)};
    const HintLattice whole = latticeOf(room, 1000);
    EXPECT_NEAR(whole.count(), 1000, 250);
    for (const vec3& shift : {vec3(0.0f), vec3(0.013f, 0.1f, -0.07f)}) {
        const Bounds part{.lower = vec3(0, 0.5f, 2.5f) + shift, .upper = vec3(1, 1, 3) + shift};
        const HintLattice fine = latticeWithin(whole, part, 1000);
        const vec3 halvings = glm::log2(whole.cell / fine.cell);
        EXPECT_NEAR(halvings.x, std::round(halvings.x), 1e-4f);
        EXPECT_LT(fine.cell.x, whole.cell.x);
        EXPECT_LT(fine.count(), 8000);
        // A hint's coordinates are whole numbers of cells of the common origin, whatever the box.
        const vec3 corner = fine.middle(ivec3(0)) / fine.cell - whole.origin / fine.cell;
        EXPECT_LT(glm::length(corner - 0.5f - glm::round(corner - 0.5f)), 1e-3f);
        EXPECT_GE(fine.within(part.lower), -1.0f);
        EXPECT_GE(fine.within(part.upper), -1.0f);
    }
    // What a camera sees of nothing but flat ground: no more hints than elsewhere.
    const Bounds wide{.lower = vec3(-100, 0, -100), .upper = vec3(100, 30, 100)};
    const Bounds ground{.lower = vec3(-10, 0, -10), .upper = vec3(10, 0, 10)};
    EXPECT_LT(latticeWithin(latticeOf(wide, 2048), ground, 2048).count(), 8 * 2048);
    const HintLattice flat = latticeOf({.lower = vec3(0), .upper = vec3(10, 0, 10)}, 500);
    EXPECT_GT(flat.cell.y, 0.0f);
    EXPECT_NEAR(flat.count(), 500, 250);
}

// In a diffuse sphere with a light at its centre each bounce brings albedo times the one before.
TEST(RadianceHints, addUpTheBouncesInASphere) {
    for (const float albedo : {0.3f, 0.8f}) {
        const Scene scene = sphereRoom(albedo);
        for (const int bounces : {1, 2, kAllBounces}) {
            const Hinted hinted(scene, {.hints = 500, .samples = 512, .bounces = bounces});
            const HintLight light = hinted.hints.at(seenFrom(hinted.tracer, vec3(0.1f)));
            const double direct = luminance(scene.lights[0].intensity) / 4.0;
            double expected = direct * albedo / (1.0 - albedo);
            expected = bounces == 1   ? direct * albedo
                       : bounces == 2 ? direct * albedo * (1.0 + albedo)
                                      : expected;
            EXPECT_NEAR(mean(light.irradiance), expected, 0.05 * expected) << albedo;
            EXPECT_LT(
                difference(light.irradiance, std::vector<vec3>(light.irradiance.size(),
                                                               vec3(static_cast<float>(expected)))),
                0.12);
            EXPECT_EQ(light.unseen, 0);
        }
    }
}

TEST(RadianceHints, showAnOpenPlaneItsSky) {
    Scene scene;
    addQuad(scene, vec3(-2, 0, 2), vec3(4, 0, 0), vec3(0, 0, -4),
            addMaterial(scene, diffuseParams(vec3(0.5f))));
    scene.environment.texels = Image<vec3>(1, 1, vec3(1, 2, 3));
    const Hinted hinted(scene);
    const Receivers floor = receiversAt({vec3(0.3f, 0, 0.2f), vec3(-1, 0, 0.7f)},
                                        {vec3(0, 1, 0), vec3(0, 1, 0)}, {0, 0}, 0.01f);
    for (const vec3& irradiance : hinted.hints.at(floor).irradiance) {
        EXPECT_NEAR(irradiance.x, kPi, 0.05f * kPi);
        EXPECT_NEAR(irradiance.z, 3.0f * kPi, 0.15f * kPi);
    }
}

// A lamp's first light is direct and not theirs; what a floor sends on to a wall is.
TEST(RadianceHints, scatterWhatLampsSend) {
    Scene scene;
    const uint32_t white = addMaterial(scene, diffuseParams(vec3(0.5f)));
    addSphere(scene, vec3(0.0f), 2.0f, 32, white);
    addSphere(scene, vec3(0.0f), 0.1f, 8,
              addMaterial(scene, diffuseParams(vec3(0.0f), vec3(100.0f))));
    const Hinted hinted(scene, {.hints = 500, .samples = 512, .bounces = 1});
    const HintLight light = hinted.hints.at(seenFrom(hinted.tracer, vec3(0.2f, 0.1f, 0.0f)));
    // pi L times the sphere's disc over the squared distance; the lamp hides little.
    const double expected = 0.5 * 100.0 * kPi * 0.01 / 4.0;
    std::vector<vec3> walls;
    const Receivers seen = seenFrom(hinted.tracer, vec3(0.2f, 0.1f, 0.0f));
    for (size_t i = 0; i < seen.positions.size(); ++i) {
        if (glm::length(seen.positions[i]) > 1.0f) {
            walls.push_back(light.irradiance[i]);
        }
    }
    EXPECT_NEAR(mean(walls), expected, 0.1 * expected);
}

TEST(RadianceHints, standScenesWithoutLightOrSurfaces) {
    const Scene empty;
    const Hinted nothing(empty);
    EXPECT_EQ(nothing.hints.count(), 0u);
    EXPECT_TRUE(nothing.hints.at(Receivers{}).irradiance.empty());

    Scene dark = glossyRoom();
    dark.lights.clear();
    const Hinted unlit(dark);
    EXPECT_EQ(unlit.hints.sampleCount(), 0u);
    EXPECT_EQ(mean(unlit.hints.at(seenFrom(unlit.tracer, vec3(0.0f))).irradiance), 0.0);

    Scene triangle;
    addVertex(triangle, vec3(0), vec3(0, 0, 1));
    addVertex(triangle, vec3(1, 0, 0), vec3(0, 0, 1));
    addVertex(triangle, vec3(0, 1, 0), vec3(0, 0, 1));
    triangle.triangles.emplace_back(0, 1, 2);
    triangle.materials_of.push_back(addMaterial(triangle, diffuseParams(vec3(0.8f))));
    triangle.lights.push_back(pointLight(vec3(0.2f, 0.2f, 1.0f), vec3(1.0f)));
    const Hinted one(triangle);
    const HintLight light =
        one.hints.at(receiversAt({vec3(0.2f, 0.2f, 0.0f)}, {vec3(0, 0, 1)}, {0}, 0.01f));
    // A plane sends itself nothing.
    EXPECT_LT(luminance(light.irradiance[0]), 0.02f);
    EXPECT_TRUE(finite(light.irradiance[0]));
}

// In a lit room, a closed box of thin walls, several cells wide.
TEST(RadianceHints, leaveAClosedBoxDark) {
    constexpr double kLeak = 1e-3;  // of the light around it
    Scene scene = cornellRoom(diffuseParams(vec3(0.7f)), diffuseParams(vec3(0.7f)));
    addBox(scene, vec3(-0.2f, 0.0f, -0.9f), vec3(0.4f, 0.6f, -0.3f), 0, true);
    const Hinted hinted(scene);
    const double inside =
        mean(hinted.hints.at(seenFrom(hinted.tracer, vec3(0.1f, 0.3f, -0.6f))).irradiance);
    const double outside =
        mean(hinted.hints.at(seenFrom(hinted.tracer, vec3(0.1f, -0.2f, 0.5f))).irradiance);
    EXPECT_GT(outside, 0.1);
    EXPECT_LT(inside, kLeak * outside);
}

// A thin wall parts a lit half of a room from one where no light comes.
TEST(RadianceHints, doNotLeakThroughAThinWall) {
    Scene scene;
    const uint32_t white = addMaterial(scene, diffuseParams(vec3(0.7f)));
    addBox(scene, vec3(-1), vec3(1), white, true);
    addQuad(scene, vec3(0.07f, -1, -1), vec3(0, 2, 0), vec3(0, 0, 2), white);
    scene.lights.push_back(pointLight(vec3(-0.5f, 0.2f, 0.1f), vec3(1.0f)));
    const Hinted hinted(scene);
    const double dark =
        mean(hinted.hints.at(seenFrom(hinted.tracer, vec3(0.5f, 0.1f, 0.0f))).irradiance);
    const double lit =
        mean(hinted.hints.at(seenFrom(hinted.tracer, vec3(-0.4f, 0.1f, 0.0f))).irradiance);
    EXPECT_LT(dark, 1e-3 * lit);
}

TEST(RadianceHints, doNotDependOnTheScale) {
    const Scene scene = glossyRoom();
    const Hinted hinted(scene);
    const vec3 eye(0.1f, 0.1f, 0.5f);
    const HintLight light = hinted.hints.at(seenFrom(hinted.tracer, eye));
    for (const float s : {1e-3f, 1e3f}) {
        const Scene other = scaled(scene, s);
        const Hinted again(other);
        const HintLight found = again.hints.at(seenFrom(again.tracer, s * eye));
        EXPECT_LT(difference(found.irradiance, light.irradiance), 2e-3) << s;
    }
}

TEST(RadianceHints, areTheSameForAnyThreadsAndWhenFilledAgain) {
    Scene scene = glossyRoom();
    const vec3 eye(0.1f, 0.1f, 0.5f);
    setThreadCount(1);
    const Hinted alone(scene);
    const HintLight light = alone.hints.at(seenFrom(alone.tracer, eye));
    setThreadCount(0);
    Hinted many(scene);
    EXPECT_EQ(many.hints.at(seenFrom(many.tracer, eye)).irradiance, light.irradiance);
    // The light moves away and comes back.
    const PunctualLight before = scene.lights[0];
    scene.lights[0].position.x -= 0.5f;
    many.hints.fill(SceneLights(many.tracer));
    EXPECT_NE(many.hints.at(seenFrom(many.tracer, eye)).irradiance, light.irradiance);
    scene.lights[0] = before;
    many.hints.fill(SceneLights(many.tracer));
    EXPECT_EQ(many.hints.at(seenFrom(many.tracer, eye)).irradiance, light.irradiance);
}

// How much a moving light's frames change, over their mean: from one to the next, and off the mean
// of both neighbours, which is noise.
struct Change {
    double step = 0.0, flicker = 0.0;
};

// A light crosses a room, a hundredth of it a frame.
Change changeUnderAMovingLight(float share) {
    constexpr int kFrames = 12;
    Scene scene = glossyRoom();
    Hinted hinted(scene);
    const Receivers receivers = seenFrom(hinted.tracer, vec3(0.1f, 0.1f, 0.5f), 1024);
    std::vector<std::vector<vec3>> frames;
    for (int frame = 0; frame < kFrames; ++frame) {
        scene.lights[0].position.x = 0.2f - 0.02f * static_cast<float>(frame);
        hinted.hints.fill(SceneLights(hinted.tracer), share);
        frames.push_back(hinted.hints.at(receivers).irradiance);
    }
    Change change;
    for (size_t f = 0; f + 1 < frames.size(); ++f) {
        change.step = std::max(change.step, difference(frames[f + 1], frames[f]));
        if (f > 0) {
            std::vector<vec3> between(frames[f].size());
            for (size_t i = 0; i < between.size(); ++i) {
                between[i] = 0.5f * (frames[f - 1][i] + frames[f + 1][i]);
            }
            change.flicker = std::max(change.flicker, difference(between, frames[f]));
        }
    }
    std::printf("step %.2f%%, flicker %.2f%%\n", 100.0 * change.step, 100.0 * change.flicker);
    return change;
}

TEST(RadianceHints, doNotFlickerUnderAMovingLight) {
    const Change change = changeUnderAMovingLight(1.0f);
    EXPECT_LT(change.step, 0.03);
    EXPECT_LT(change.flicker, 0.015);
    EXPECT_GT(change.step, 1e-3);  // it did move
    EXPECT_LT(changeUnderAMovingLight(0.25f).flicker, 0.5 * change.flicker);
}

// Filled by a share, again and again, they come to what they are when filled at once.
TEST(RadianceHints, filledBySharesComeToTheSame) {
    Scene scene = glossyRoom();
    Hinted hinted(scene);
    const Receivers receivers = seenFrom(hinted.tracer, vec3(0.1f, 0.1f, 0.5f));
    const std::vector<vec3> before = hinted.hints.at(receivers).irradiance;
    scene.lights[0].position.x -= 0.5f;
    const SceneLights lights(hinted.tracer);
    hinted.hints.fill(lights, 0.5f);
    const std::vector<vec3> half = hinted.hints.at(receivers).irradiance;
    for (int i = 0; i < 10; ++i) {
        hinted.hints.fill(lights, 0.5f);
    }
    const std::vector<vec3> shared = hinted.hints.at(receivers).irradiance;
    hinted.hints.fill(lights);
    const std::vector<vec3> whole = hinted.hints.at(receivers).irradiance;
    EXPECT_LT(difference(shared, whole), 2e-3);
    EXPECT_NEAR(difference(half, whole) / difference(before, whole), 0.5, 0.05);
}

// All bounces are not followed to their end, but estimated from there.
TEST(RadianceHints, allBouncesAreAsMany) {
    const Scene scene = glossyRoom();
    const Hinted all(scene);
    HintsParams many = kFew;
    many.bounces = 64;
    const Hinted followed(scene, many);
    const Receivers receivers = seenFrom(all.tracer, vec3(0.1f, 0.1f, 0.5f));
    EXPECT_LT(
        difference(all.hints.at(receivers).irradiance, followed.hints.at(receivers).irradiance),
        0.02);
}

// A finer volume within the scene's tells the same light, and the border between them is no step.
TEST(RadianceHints, ofNestedVolumesAgree) {
    const Scene scene = sphereRoom(0.5f);
    const Bounds part{.lower = vec3(0.2f, -1.0f, -1.0f), .upper = vec3(2.0f, 1.0f, 1.0f)};
    const Hinted hinted(scene, {.hints = 500, .samples = 512, .bounces = 1}, {part});
    const Hinted coarse(scene, {.hints = 500, .samples = 512, .bounces = 1});
    EXPECT_GT(hinted.hints.count(), coarse.hints.count());
    const Receivers receivers = seenFrom(hinted.tracer, vec3(0.1f));
    EXPECT_LT(
        difference(hinted.hints.at(receivers).irradiance, coarse.hints.at(receivers).irradiance),
        0.1);
    const double expected = 0.5 * luminance(scene.lights[0].intensity) / 4.0;
    EXPECT_NEAR(mean(hinted.hints.at(receivers).irradiance), expected, 0.05 * expected);
}

}  // namespace
}  // namespace sheen
