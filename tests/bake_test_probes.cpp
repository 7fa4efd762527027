// Light probes, against closed forms and against what surfaces get.
#include <gtest/gtest.h>

#include <cmath>

#include "bake/light_probes.h"
#include "bake/points.h"
#include "core/parallel.h"
#include "sh/sh.h"
#include "test_bake.h"

namespace sheen {
namespace {

LightProbes probesOf(const Scene& scene, const HintLattice& lattice, BakeParams params = {}) {
    params.quiet = true;
    return bakeLightProbes(Tracer(scene), lattice, params);
}

// One in the middle of a box of side 2 about the origin.
HintLattice one() { return lightProbeLattice({.lower = vec3(-1), .upper = vec3(1)}, ivec3(1)); }

// Irradiance of a surface with a unit normal, by the first three bands [RH01].
vec3 irradianceOf(const ShLight& light, const vec3& n) {
    constexpr float kBands[] = {kPi, 2.0f * kPi / 3.0f, kPi / 4.0f};
    const shared::ShVector y = shared::shBasis(n, kLightProbeOrder);
    vec3 sum(0.0f);
    for (int l = 0; l < kLightProbeOrder; ++l) {
        for (int k = l * l; k < (l + 1) * (l + 1); ++k) {
            sum += kBands[l] * y.c[k] * light[static_cast<size_t>(k)];
        }
    }
    return sum;
}

// As far from a hemisphere's sums as floats are.
constexpr float kProbeRounding = 2e-4f;

TEST(LightProbes, anEvenSkyHasOneCoefficient) {
    Scene scene;
    addQuad(scene, vec3(50, -1, 0), vec3(0.1f, 0, 0), vec3(0, 0, -0.1f),
            addMaterial(scene, diffuseParams(vec3(0.0f))));  // far off, and hardly seen
    const vec3 radiance(0.5f, 1.0f, 2.0f);
    addSky(scene, radiance);
    const LightProbes probes = probesOf(scene, one());
    ASSERT_EQ(probes.free, 1);
    const ShLight& light = probes.light[0];
    ASSERT_EQ(light.size(), 9u);
    EXPECT_LT(maxAbs(light[0] / (std::sqrt(4.0f * kPi) * radiance) - 1.0f), kProbeRounding);
    for (size_t k = 1; k < light.size(); ++k) {
        EXPECT_LT(maxAbs(light[k]), kProbeRounding) << k;
    }
    EXPECT_LT(maxAbs(irradianceOf(light, vec3(0.6f, 0, 0.8f)) / (kPi * radiance) - 1.0f),
              kProbeRounding);
}

// Of light from one direction the coefficients are the basis there; the irradiance of what faces it
// is 17/16 of what it is, for want of the bands above.
TEST(LightProbes, aSunHasTheBasisOfItsDirection) {
    Scene scene;
    const vec3 toward = glm::normalize(vec3(1, 2, -3));
    addQuad(scene, vec3(-9, -5, 9), vec3(18, 0, 0), vec3(0, 0, -18),
            addMaterial(scene, diffuseParams(vec3(0.0f))));
    scene.lights.push_back(directionalLight(-toward, vec3(3, 2, 1)));
    const ShLight light = probesOf(scene, one()).light[0];
    const shared::ShVector y = shared::shBasis(toward, kLightProbeOrder);
    for (size_t k = 0; k < light.size(); ++k) {
        EXPECT_LT(maxAbs(light[k] - vec3(3, 2, 1) * y.c[k]), 1e-5f) << k;
    }
    const vec3 along(light[3].x, light[1].x, light[2].x);  // x, y and z
    EXPECT_LT(maxAbs(along / light[0].x - std::sqrt(3.0f) * toward), 1e-5f);
    EXPECT_LT(maxAbs(irradianceOf(light, toward) / vec3(3, 2, 1) - 17.0f / 16.0f), 1e-4f);
    // In its shadow there is none.
    addQuad(scene, vec3(-9, 5, 9), vec3(18, 0, 0), vec3(0, 0, -18), 0);
    EXPECT_EQ(probesOf(scene, one()).light[0], ShLight(9, vec3(0.0f)));
}

// A small lamp is a sun of as much irradiance, wherever it is.
TEST(LightProbes, aSmallLampIsAsASun) {
    for (const vec3& toward : {vec3(0, 1, 0), vec3(1, 0, 0), glm::normalize(vec3(1, 0.05f, -1)),
                               glm::normalize(vec3(-1, -1, 1))}) {
        Scene scene;
        const float side = 0.2f, distance = 4.0f;
        const uint32_t lamp = addMaterial(scene, diffuseParams(vec3(0.0f), vec3(5.0f)));
        const mat3 frame = tangentFrame(-toward);
        addQuad(scene, distance * toward - 0.5f * side * (frame[0] + frame[1]), side * frame[0],
                side * frame[1], lamp);
        const ShLight light = probesOf(scene, one()).light[0];
        const float expected = 5.0f * side * side / (distance * distance);
        const shared::ShVector y = shared::shBasis(toward, kLightProbeOrder);
        for (size_t k = 0; k < light.size(); ++k) {
            EXPECT_NEAR(light[k].x, expected * y.c[k], 0.01f * expected) << k;
        }
        EXPECT_EQ(probesOf(scene, one(), {.indirect_only = true}).light[0], ShLight(9, vec3(0.0f)));
    }
}

// All walls shine and scatter half: radiance is 2 everywhere, half of it straight from walls.
// A probe stands for its cell: a light in it is as one on the cell's edge, and none at the probe.
TEST(LightProbes, lightsInTheirCellsAreNotEndless) {
    Scene scene;
    addBox(scene, vec3(-1), vec3(1), addMaterial(scene, diffuseParams(vec3(0.0f))), true);
    for (const float x : {0.0f, 1e-6f, 0.01f, 0.5f}) {
        for (const float candela : {1.0f, 1e30f}) {
            scene.lights = {pointLight(vec3(x, 0, 0), vec3(candela))};
            const ShLight light = probesOf(scene, one()).light[0];
            for (const vec3& c : light) {
                EXPECT_TRUE(finite(c)) << x;
            }
            // One cell, two wide: what is nearer than one counts as if it were one away.
            EXPECT_LE(light[0].x, 1.01f * candela * shared::shBasis(vec3(1, 0, 0), 1).c[0]) << x;
        }
    }
}

TEST(LightProbes, aFurnaceAddsUpAllBounces) {
    Scene scene;
    addBox(scene, vec3(-1), vec3(1), addMaterial(scene, diffuseParams(vec3(0.5f), vec3(1.0f))),
           true);
    const ShLight light = probesOf(scene, one()).light[0];
    EXPECT_NEAR(light[0].x / std::sqrt(4.0f * kPi), 2.0f, 0.03f);
    for (size_t k = 1; k < light.size(); ++k) {
        EXPECT_LT(std::abs(light[k].x), 0.05f * light[0].x) << k;
    }
}

// Close to a wall the light that a probe has for it is that of the wall, within what three bands
// leave out.
TEST(LightProbes, agreeWithSurfaces) {
    const Scene scene = cornellRoom(diffuseParams(vec3(0.5f)), diffuseParams(vec3(0.5f)));
    const Tracer tracer(scene);
    const HintLattice lattice = lightProbeLattice(
        {.lower = vec3(0.2f, 0.9f, -0.6f), .upper = vec3(0.6f, 0.999f, -0.2f)}, ivec3(2, 1, 2));
    const BakeParams params{.bounces = 1, .indirect_only = true, .quiet = true};
    const LightProbes probes = bakeLightProbes(tracer, lattice, params);
    std::vector<AskedPoint> points;
    for (int i = 0; i < lattice.count(); ++i) {
        points.push_back({.position = lattice.middle(lattice.at(i)) * vec3(1, 0, 1) + vec3(0, 1, 0),
                          .normal = vec3(0, -1, 0),
                          .width = 0.05f});
    }
    const LightAtPoints at = lightAtPoints(tracer, points, params);
    for (size_t i = 0; i < points.size(); ++i) {
        const float of_probe = luminance(irradianceOf(probes.light[i], vec3(0, -1, 0)));
        EXPECT_NEAR(of_probe / luminance(at.indirect[i]), 1.0f, 0.08f) << i;
    }
}

// Marked, and not black.
TEST(LightProbes, thoseWithinSolidsHaveTheLightAround) {
    Scene scene = cornellRoom(diffuseParams(vec3(0.5f)), diffuseParams(vec3(0.5f)));
    const HintLattice lattice = lightProbeLattice(scene.bounds, ivec3(8));
    const LightProbes probes = probesOf(scene, lattice, {.bounces = 1});
    int solid = 0;
    for (int i = 0; i < lattice.count(); ++i) {
        const auto probe = static_cast<size_t>(i);
        const vec3 p = lattice.middle(lattice.at(i));
        const vec3 in_box = glm::max(vec3(-0.6f, -1.0f, -0.5f) - p, p - vec3(0.0f, -0.4f, 0.1f));
        const float off = glm::max(in_box.x, glm::max(in_box.y, in_box.z));
        const float in_sphere = 0.3f - glm::distance(p, vec3(0.45f, -0.7f, -0.1f));
        if (in_sphere < 0.0f || in_sphere > 0.02f) {  // else its facets decide
            EXPECT_EQ(probes.solid[probe] != 0, off < 0.0f || in_sphere > 0.0f) << i;
        }
        solid += probes.solid[probe];
        EXPECT_GT(probes.light[probe][0].x, 0.0f) << i;
    }
    EXPECT_EQ(probes.free, lattice.count() - solid);
    EXPECT_GT(solid, 10);
}

TEST(LightProbes, areTheSameForAnyNumberOfThreads) {
    const Scene scene = cornellRoom(diffuseParams(vec3(0.5f)), diffuseParams(vec3(0.5f)));
    const HintLattice lattice = lightProbeLattice(scene.bounds, 0.7f);
    EXPECT_EQ(lattice.counts, ivec3(3));
    const int threads = threadCount();
    setThreadCount(1);
    const LightProbes single = probesOf(scene, lattice, {.bounces = 1});
    setThreadCount(threads + 2);
    const LightProbes many = probesOf(scene, lattice, {.bounces = 1});
    setThreadCount(threads);
    EXPECT_EQ(single.light, many.light);
}

TEST(LightProbes, tooManyAreRefused) {
    EXPECT_THROW(lightProbeLattice({.lower = vec3(0), .upper = vec3(1)}, ivec3(200)), Error);
    EXPECT_THROW(lightProbeLattice({.lower = vec3(0), .upper = vec3(1)}, 1e-30f), Error);
}

}  // namespace
}  // namespace sheen
