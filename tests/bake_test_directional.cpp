// Where the light of a lightmap's texels comes from, against closed forms and its irradiance.
#include <gtest/gtest.h>

#include <cmath>

#include "sh/sh.h"
#include "test_bake.h"

namespace sheen {
namespace {

// What the second band says of the irradiance about a direction, as long as no light is below it.
vec3 irradianceAlong(const Baked& baked, size_t i, const vec3& n) {
    const float scale = std::sqrt(4.0f * kPi / 3.0f);
    return scale * (n.y * baked.sh[1].pixels[i] + n.z * baked.sh[2].pixels[i] +
                    n.x * baked.sh[3].pixels[i]);
}

Scene greyFloor() {
    Scene scene;
    addQuad(scene, vec3(-1, 0, 1), vec3(2, 0, 0), vec3(0, 0, -2),
            addMaterial(scene, diffuseParams(vec3(0.5f))));
    return scene;
}

// Above a floor under an even sky: half of the sphere.
TEST(Directional, anEvenSky) {
    Scene scene = greyFloor();
    const vec3 radiance(0.5f, 1.0f, 2.0f);
    addSky(scene, radiance);
    const Bench bench(scene, 16);
    for (const BakeMethod method : {BakeMethod::kRecords, BakeMethod::kTexels}) {
        const Baked baked = bench.bake({.method = method, .directional = true});
        ASSERT_EQ(baked.sh.size(), 4u);
        bench.forSeen([&](size_t i) {
            const float constant = std::sqrt(kPi), up = std::sqrt(3.0f * kPi) / 2.0f;
            const vec3 expected[] = {vec3(constant), vec3(up), vec3(0.0f), vec3(0.0f)};
            for (size_t k = 0; k < 4; ++k) {
                EXPECT_LT(maxAbs(baked.sh[k].pixels[i] / radiance - expected[k]), 2e-3f) << k;
            }
        });
    }
}

TEST(Directional, aSunHasTheBasisOfItsDirection) {
    Scene scene = greyFloor();
    const vec3 toward = glm::normalize(vec3(1, 2, -3));
    scene.lights.push_back(directionalLight(-toward, vec3(3, 2, 1)));
    const Bench bench(scene, 16);
    const Baked baked = bench.bake({.directional = true});
    const shared::ShVector y = shared::shBasis(toward, kDirectionalOrder);
    bench.forSeen([&](size_t i) {
        for (size_t k = 0; k < 4; ++k) {
            EXPECT_LT(maxAbs(baked.sh[k].pixels[i] - vec3(3, 2, 1) * y.c[k]), 1e-4f) << k;
        }
        const vec3 tilted = glm::normalize(vec3(0.3f, 1, -0.2f));
        EXPECT_LT(
            maxAbs(irradianceAlong(baked, i, tilted) - vec3(3, 2, 1) * glm::dot(toward, tilted)),
            1e-4f);
    });
}

// The second band along a texel's normal is its irradiance: of lamps, lights and surfaces, by
// records and at every texel.
TEST(Directional, holdsTheIrradiance) {
    Scene scene = cornellRoom(diffuseParams(vec3(0.5f)), diffuseParams(vec3(0.5f)));
    addQuad(scene, vec3(-0.4f, 0.9f, -0.2f), vec3(0.3f, 0, 0), vec3(0, 0, 0.3f),
            addMaterial(scene, diffuseParams(vec3(0.5f), vec3(4.0f))));
    const Bench bench(scene, 48);
    for (const BakeMethod method : {BakeMethod::kRecords, BakeMethod::kTexels}) {
        const Baked baked = bench.bake({.method = method, .directional = true});
        double squares = 0.0, mean = 0.0;
        bench.forSeen([&](size_t i) {
            const vec3 whole = baked.frame.direct.pixels[i] + baked.frame.indirect.pixels[i];
            const vec3 told = irradianceAlong(baked, i, bench.map.receivers.normals[i]);
            squares += std::pow(luminance(whole - told), 2.0);
            mean += luminance(whole);
            EXPECT_EQ(baked.sh[0].pixels[i].x > 0.0f, whole.x > 0.0f);
        });
        const double count = bench.map.receivers.counts.seen;
        EXPECT_LT(std::sqrt(squares / count) / (mean / count), 0.02) << static_cast<int>(method);
    }
}

TEST(Directional, notByPaths) {
    const Scene scene = greyFloor();
    const Bench bench(scene, 16);
    EXPECT_THROW(bench.bake({.method = BakeMethod::kReference, .directional = true}), Error);
    EXPECT_TRUE(bench.bake().sh.empty());
}

}  // namespace
}  // namespace sheen
