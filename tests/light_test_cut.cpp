// Light of all bounces by photons and an illumination cut.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "core/bounces.h"
#include "core/parallel.h"
#include "light/illumination_cut.h"
#include "light/photon_tracer.h"
#include "light/scattered_again.h"
#include "light_test_rooms.h"

namespace sheen {
namespace {

constexpr int kPhotons = 50'000;

struct LitByPhotons {
    Tracer tracer;
    SceneLights lights;
    ScatteredOnce once;
    ScatteredAgain again;

    LitByPhotons(const Scene& scene, int bounces)
        : tracer(scene),
          lights(tracer),
          once(tracer, &lights),
          again(once, std::make_unique<PhotonLight>(tracer, lights, kPhotons, bounces), {},
                bounces) {}
};

const vec3 kWithin(0.4f, 0.3f, -0.2f);

TEST(IlluminationCut, AddsUpTheBouncesInASphere) {
    // Of estimates of density on a curved surface.
    constexpr double kTolerance = 0.02;
    for (const float albedo : {0.5f, 0.8f}) {
        const Scene scene = sphereRoom(albedo);
        for (const int bounces : {2, 3, kAllBounces}) {
            const LitByPhotons lit(scene, bounces);
            const double once = meanRadiance(lit.once, kWithin).y;
            const double series = bounces == kAllBounces ? 1.0 / (1.0 - albedo)
                                                         : (1.0 - std::pow(albedo, bounces)) /
                                                               (1.0 - static_cast<double>(albedo));
            EXPECT_NEAR(meanRadiance(lit.again, kWithin).y, once * series,
                        once * series * kTolerance)
                << "albedo " << albedo << ", bounces " << bounces;
            EXPECT_LT(lit.again.missedShare(), 0.02);
            EXPECT_GE(lit.again.keptCount(), 2000u);
        }
    }
}

// Photons carry what lights send: their power adds up to the flux that each bounce receives.
TEST(IlluminationCut, PhotonsHaveThePowerOfTheLight) {
    const float albedo = 0.5f;
    const Scene scene = sphereRoom(albedo);
    const Tracer tracer(scene);
    const SceneLights lights(tracer);
    const std::vector<Photon> photons = tracePhotons(tracer, lights, {.bounces = 3}, kPhotons);
    const double flux = 4.0 * kPi * 3.0;
    std::vector<double> received(4);
    for (const Photon& photon : photons) {
        ASSERT_GE(photon.scattered, 1);
        ASSERT_LE(photon.scattered, 3);
        received[static_cast<size_t>(photon.scattered)] += photon.power.y;
    }
    for (int k = 1; k <= 3; ++k) {
        const double expected = flux * std::pow(albedo, k);
        EXPECT_NEAR(received[static_cast<size_t>(k)], expected, 0.02 * expected) << k;
    }
}

TEST(IlluminationCut, DoesNotLeakThroughAThinWall) {
    Scene scene;
    const uint32_t white = addMaterial(scene, diffuseParams(vec3(0.8f)));
    addBox(scene, vec3(-2, -1, -1), vec3(2, 1, 1), white, true);
    addQuad(scene, vec3(0, -1, -1), vec3(0, 2, 0), vec3(0, 0, 2), white);
    scene.lights.push_back(pointLight(vec3(-1, 0, 0), vec3(1.0f)));
    const LitByPhotons lit(scene, kAllBounces);
    const vec3 lit_eye(-0.8f, 0.2f, 0.1f), dark_eye(0.9f, -0.1f, 0.2f);
    EXPECT_GT(meanRadiance(lit.again, lit_eye).y, 2.0f * meanRadiance(lit.once, lit_eye).y);
    // A node beside the wall reaches as far along the floor as its photons do.
    constexpr float kLeak = 0.01f;
    EXPECT_LT(meanRadiance(lit.again, dark_eye).y, kLeak * meanRadiance(lit.again, lit_eye).y);
}

TEST(IlluminationCut, DoesNotDependOnThreads) {
    const Scene scene = glossyRoom();
    const int threads = threadCount();
    std::vector<vec3> means;
    for (const int count : {1, 4}) {
        setThreadCount(count);
        const LitByPhotons lit(scene, kAllBounces);
        means.push_back(meanRadiance(lit.again, vec3(0.1f, 0.2f, 0.3f)));
    }
    setThreadCount(threads);
    EXPECT_EQ(means[0], means[1]);
}

TEST(IlluminationCut, HasNothingToAddWhereNothingShines) {
    Scene scene = sphereRoom(0.8f);
    scene.lights.clear();
    const LitByPhotons dark(scene, kAllBounces);
    EXPECT_EQ(dark.again.keptCount(), 0u);
    EXPECT_EQ(meanRadiance(dark.again, vec3(0.0f)), vec3(0.0f));
    const Scene empty;
    const Tracer tracer(empty);
    const SceneLights lights(tracer);
    EXPECT_EQ(PhotonLight(tracer, lights, 1000, 2).size(), 0u);
}

}  // namespace
}  // namespace sheen
