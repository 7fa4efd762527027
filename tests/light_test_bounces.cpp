// Light scattered more than once, against closed forms.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <utility>
#include <vector>

#include "core/bounces.h"
#include "core/directions.h"
#include "core/parallel.h"
#include "light/element_light.h"
#include "light/place_elements.h"
#include "light/scattered_again.h"
#include "light_test_rooms.h"
#include "rays/jitter.h"
#include "test_scenes.h"

namespace sheen {
namespace {

// Points of the surfaces that are seen from `eye`, in all directions: light is looked for there.
std::vector<ElementSite> seenFrom(const Tracer& tracer, const vec3& eye, int count) {
    std::vector<ElementSite> sites;
    for (int i = 0; i < count; ++i) {
        const vec2 u = randomPlace(static_cast<uint32_t>(i), 0);
        vec3 d = cosineDirection(u);
        d.z *= i % 2 == 0 ? 1.0f : -1.0f;
        Hit hit;
        tracer.meet({.origin = eye, .directions = {&d, 1}}, &hit);
        if (hit.found()) {
            sites.push_back(elementSiteAt(tracer.scene(), hit, vec2(hit.u, hit.v), -d));
        }
    }
    return sites;
}

struct Lit {
    Tracer tracer;
    ScatteredOnce once;
    ScatteredAgain again;

    Lit(const Scene& scene, const vec3& eye, int bounces)
        : tracer(scene),
          once(tracer),
          again(once,
                std::make_unique<ElementLight>(
                    once, placeElements(tracer, seenFrom(tracer, eye, 256)), bounces),
                {}, bounces) {}
};

constexpr double kMeshError = 4e-3;  // of 48 rings, over all bounces

TEST(ScatteredAgain, AddsUpTheBouncesInASphere) {
    const vec3 eye(0.4f, 0.3f, -0.2f);
    for (const float albedo : {0.5f, 0.8f, 0.95f}) {
        const Scene scene = sphereRoom(albedo);
        for (const int bounces : {2, 3, kAllBounces}) {
            const Lit lit(scene, eye, bounces);
            const double once = meanRadiance(lit.once, eye).y;
            const double series = bounces == kAllBounces ? 1.0 / (1.0 - albedo)
                                                         : (1.0 - std::pow(albedo, bounces)) /
                                                               (1.0 - static_cast<double>(albedo));
            const double slope = 1.0 / (1.0 - albedo);  // errors of each bounce add up
            EXPECT_NEAR(meanRadiance(lit.again, eye).y, once * series,
                        once * series * kMeshError * std::min(slope, 4.0))
                << "albedo " << albedo << ", bounces " << bounces;
            EXPECT_LT(lit.again.missedShare(), 0.02);
        }
    }
}

// Where no elements are, ways go on, and bring the same light.
TEST(ScatteredAgain, FindsTheSameWithoutElements) {
    const vec3 eye(0.4f, 0.3f, -0.2f);
    const Scene scene = sphereRoom(0.5f);
    const Tracer tracer(scene);
    const ScatteredOnce once(tracer);
    const ScatteredAgain again(once, std::make_unique<ElementLight>(once, Elements(), 3), {}, 3);
    constexpr double kNoise = 0.02;  // 4 standard errors
    const double expected = meanRadiance(once, eye).y * 1.75;
    EXPECT_NEAR(meanRadiance(again, eye).y, expected, kNoise * expected);
    EXPECT_EQ(again.missedShare(), 1.0);
}

// For all bounces cells gather what is not kept, each once.
TEST(ScatteredAgain, GathersWithoutElements) {
    const vec3 eye(0.4f, 0.3f, -0.2f);
    const Scene scene = sphereRoom(0.5f);
    const Tracer tracer(scene);
    const ScatteredOnce once(tracer);
    const ScatteredAgain again(once, std::make_unique<ElementLight>(once, Elements(), kAllBounces),
                               {}, kAllBounces);
    constexpr double kNoise = 0.02;
    const double expected = meanRadiance(once, eye).y * 2.0;
    EXPECT_NEAR(meanRadiance(again, eye).y, expected, kNoise * expected);
    EXPECT_EQ(again.missedShare(), 1.0);
}

// A wall without thickness parts a lit room from one that no light enters.
TEST(ScatteredAgain, DoesNotLeakThroughAThinWall) {
    Scene scene;
    const uint32_t white = addMaterial(scene, diffuseParams(vec3(0.8f)));
    addBox(scene, vec3(-2, -1, -1), vec3(2, 1, 1), white, true);
    addQuad(scene, vec3(0, -1, -1), vec3(0, 2, 0), vec3(0, 0, 2), white);
    scene.lights.push_back(pointLight(vec3(-1, 0, 0), vec3(1.0f)));
    const vec3 lit_eye(-0.8f, 0.2f, 0.1f), dark_eye(0.9f, -0.1f, 0.2f);
    const Tracer tracer(scene);
    const ScatteredOnce once(tracer);
    // Elements of both rooms, on both sides of the wall and of what it stands on.
    std::vector<ElementSite> seen = seenFrom(tracer, lit_eye, 256);
    const std::vector<ElementSite> others = seenFrom(tracer, dark_eye, 256);
    seen.insert(seen.end(), others.begin(), others.end());
    const ScatteredAgain again(
        once, std::make_unique<ElementLight>(once, placeElements(tracer, seen), kAllBounces), {},
        kAllBounces);
    EXPECT_GT(meanRadiance(again, lit_eye).y, 2.0f * meanRadiance(once, lit_eye).y);
    // An element knows of walls what it sees of them in a hundred directions.
    constexpr float kLeak = 1e-3f;
    EXPECT_LT(meanRadiance(again, dark_eye).y, kLeak * meanRadiance(again, lit_eye).y);
}

// Amid light that is the same everywhere a mirror shows that light.
TEST(ScatteredAgain, AMirrorShowsTheRoom) {
    Scene scene = sphereRoom(0.8f);
    const uint32_t mirror = addMaterial(scene, glossyParams(vec3(1.0f), 1.0f, 0.1f));
    addQuad(scene, vec3(1.5f, -0.4f, -0.4f), vec3(0, 0.8f, 0), vec3(0, 0, 0.8f), mirror);
    const vec3 eye(0.4f, 0.3f, -0.2f);
    const Lit lit(scene, eye, kAllBounces);
    const auto see = [&](const OutgoingLight& light, const vec3& d) {
        vec4 seen;
        light.cast({.origin = eye, .directions = {&d, 1}}, &seen);
        return seen.y;
    };
    double shown = 0.0, wall = 0.0;
    constexpr int kCount = 256;
    for (uint32_t i = 0; i < kCount; ++i) {
        const vec2 u = 0.5f * randomPlace(i, 3) - 0.25f;
        // But for what the light itself does to the mirror.
        const vec3 d = glm::normalize(vec3(1.5f, u) - eye);
        shown += (see(lit.again, d) - see(lit.once, d)) / kCount;
        wall += see(lit.again, glm::normalize(vec3(-1.5f, u) - eye)) / kCount;
    }
    // What the mirror hides of the sphere behind it, and shadows, is not quite as bright.
    constexpr double kTolerance = 0.08;
    EXPECT_NEAR(shown, wall, kTolerance * wall);
}

// Where half of a record's rays meet a glossy wall close by, few of the ways that go on from there
// see what is small and bright: left to chance, such records are specks.
TEST(ScatteredAgain, RecordsBesideAGlossyWallAgree) {
    Scene scene;
    const uint32_t glossy = addMaterial(scene, glossyParams(vec3(0.8f), 1.0f, 0.6f));
    const uint32_t white = addMaterial(scene, diffuseParams(vec3(0.5f)));
    const uint32_t bright = addMaterial(scene, diffuseParams(vec3(0.0f), vec3(30.0f)));
    addBox(scene, vec3(0.0f), vec3(2.0f), {glossy, white, white, white, white, white}, true);
    addQuad(scene, vec3(0.5f, 1.0f, 0.9f), vec3(0, 0, 0.2f), vec3(0.2f, 0, 0), bright);
    const Lit lit(scene, vec3(1.0f), 2);
    const vec3 eye(0.02f, 1.98f, 1.0f);  // looks down
    constexpr uint32_t kRays = 432, kRecords = 48;
    // What the wall hands on along its lobe, by rays that are cast together, or each alone and as
    // if it stood for nothing around it: mean and variance over records.
    const auto momentsOf = [&](bool together) {
        const std::vector<float> angles(together ? kRays : 0, 2.0f * kPi / kRays);
        double sum = 0.0, squares = 0.0;
        for (uint32_t i = 0; i < kRecords; ++i) {
            std::vector<vec3> directions;
            for (uint32_t k = 0; k < kRays; ++k) {
                const vec2 strata = (vec2(k / 24, k % 24) + randomPlace(i, k)) / vec2(18, 24);
                const vec3 d = cosineDirection(strata);
                directions.emplace_back(d.x, -d.z, d.y);
            }
            std::vector<vec4> all(kRays), once(kRays);
            const uint32_t each = together ? kRays : 1;
            for (uint32_t k = 0; k < kRays; k += each) {
                const Rays rays{.origin = eye,
                                .directions = std::span(directions).subspan(k, each),
                                .solid_angles = angles};
                lit.again.cast(rays, &all[k]);
                lit.once.cast(rays, &once[k]);
            }
            double mean = 0.0;
            for (uint32_t k = 0; k < kRays; ++k) {
                mean += directions[k].x < 0.0f ? double{all[k].y - once[k].y} / kRays : 0.0;
            }
            sum += mean / kRecords;
            squares += mean * mean / kRecords;
        }
        return std::pair(sum, squares - sum * sum);
    };
    const auto [alone, variance_alone] = momentsOf(false);
    const auto [together, variance_together] = momentsOf(true);
    EXPECT_NEAR(together, alone, 4.0 * std::sqrt(variance_alone / kRecords));
    EXPECT_LT(variance_together, 0.2 * variance_alone);
}

// Nor on who asks first.
TEST(ScatteredAgain, DoesNotDependOnThreads) {
    const Scene scene = glossyRoom();
    const vec3 eye(0.1f, 0.2f, 0.3f);
    const std::vector<vec3> eyes = {eye, vec3(-0.3f, 0.1f, 0.2f), vec3(0.2f, -0.4f, -0.1f)};
    const Tracer tracer(scene);
    const ScatteredOnce once(tracer);
    const int threads = threadCount();
    for (const bool kept : {true, false}) {
        std::vector<std::vector<vec3>> means;
        for (const int count : {1, 4}) {
            setThreadCount(count);
            Elements elements =
                kept ? placeElements(tracer, seenFrom(tracer, eye, 256)) : Elements();
            const ScatteredAgain again(
                once, std::make_unique<ElementLight>(once, std::move(elements), kAllBounces), {},
                kAllBounces);
            std::vector<vec3> seen(eyes.size());
            parallelFor(static_cast<int>(eyes.size()), [&](int i) {
                const auto k =
                    static_cast<size_t>(count == 1 ? i : static_cast<int>(eyes.size()) - 1 - i);
                seen[k] = meanRadiance(again, eyes[k]);
            });
            means.push_back(seen);
        }
        EXPECT_EQ(means[0], means[1]) << (kept ? "kept" : "gathered");
    }
    setThreadCount(threads);
}

// Elements far from the origin, or in scenes of other units, are found as well.
TEST(ScatteredAgain, WorksFarOffAndAtAnyScale) {
    const vec3 eye(0.4f, 0.3f, -0.2f);
    const double expected = [&] {
        const Scene scene = sphereRoom(0.5f);
        const Lit lit(scene, eye, kAllBounces);
        return meanRadiance(lit.again, eye).y / meanRadiance(lit.once, eye).y;
    }();
    for (const float scale : {1e-4f, 1e4f}) {
        const Scene scene = scaled(sphereRoom(0.5f), scale);
        const Lit lit(scene, scale * eye, kAllBounces);
        EXPECT_NEAR(meanRadiance(lit.again, scale * eye).y / meanRadiance(lit.once, scale * eye).y,
                    expected, 1e-3 * expected);
    }
    // A pebble so far off that floats hardly tell its points apart.
    Scene scene = sphereRoom(0.5f);
    addBox(scene, vec3(1e6f), vec3(1e6f + 1.0f), addMaterial(scene, diffuseParams(vec3(0.5f))),
           false);
    std::vector<ElementSite> sites;
    const Tracer tracer(scene);
    Hit hit;
    const vec3 d = glm::normalize(vec3(1.0f));
    tracer.meet({.origin = vec3(1e6f - 1.0f), .directions = {&d, 1}}, &hit);
    ASSERT_TRUE(hit.found());
    sites.push_back(elementSiteAt(scene, hit, vec2(hit.u, hit.v), -d));
    for (const ElementSite& site : seenFrom(tracer, eye, 64)) {
        sites.push_back(site);
    }
    EXPECT_GT(placeElements(tracer, sites).size(), 0u);
}

// Nothing is there, or nothing shines.
TEST(ScatteredAgain, HasNothingToAddWhereNothingShines) {
    Scene scene = sphereRoom(0.8f);
    scene.lights.clear();
    const Lit dark(scene, vec3(0.0f), kAllBounces);
    EXPECT_EQ(meanRadiance(dark.again, vec3(0.0f)), vec3(0.0f));
    const Tracer tracer(scene);
    EXPECT_EQ(placeElements(tracer, {}).size(), 0u);
}

}  // namespace
}  // namespace sheen
