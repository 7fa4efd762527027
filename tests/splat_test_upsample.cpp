// Light of few pixels on many.
#include <gtest/gtest.h>

#include <cmath>

#include "splat/upsample.h"
#include "test_scenes.h"

namespace sheen {
namespace {

Receivers roomBy(const Scene& scene, int width, int height) {
    return receiversOf(scene, renderGBuffer(Tracer(scene), scene.cameras.front(), width, height), 0,
                       false);
}

constexpr float kWeightSum = 2.0f;

template <class Light>
SplatBuffer splatOf(const Receivers& receivers, const Light& light) {
    SplatBuffer splat;
    splat.irradiance = Image<vec4>(receivers.image.width, receivers.image.height);
    splat.specular = splat.irradiance;
    for (size_t i = 0; i < receivers.positions.size(); ++i) {
        if (receivers.seen(i)) {
            splat.irradiance.pixels[i] = kWeightSum * vec4(light(receivers, i), 1.0f);
            splat.specular.pixels[i] = kWeightSum * vec4(0.5f * light(receivers, i), 0.0f);
        }
    }
    return splat;
}

TEST(Upsampling, ConstantLightStaysAndNothingIsBlack) {
    const Scene scene = glossyRoom();
    const Receivers coarse = roomBy(scene, 20, 15), fine = roomBy(scene, 41, 30);
    const vec3 light(1.0f, 2.0f, 3.0f);
    const SplatBuffer splat =
        Upsampling(coarse, fine)
            .of(splatOf(coarse, [&](const Receivers&, size_t) { return light; }), {})
            .splat;
    ASSERT_EQ(splat.irradiance.width, 41);
    ASSERT_EQ(splat.irradiance.height, 30);
    for (size_t i = 0; i < fine.positions.size(); ++i) {
        if (!fine.seen(i)) {
            EXPECT_EQ(splat.irradiance.pixels[i].w, 0.0f);
            continue;
        }
        const vec4& sum = splat.irradiance.pixels[i];
        EXPECT_NEAR(sum.w, kWeightSum, 1e-5f) << i;
        EXPECT_LT(glm::length(vec3(sum) / sum.w - light), 1e-5f);
    }
}

// A light that depends on place and thing alone is that of each pixel's own: what lies before
// another thing takes nothing from it.
TEST(Upsampling, SurfacesKeepTheirOwnLight) {
    const Scene scene = glossyRoom();
    const Receivers coarse = roomBy(scene, 32, 32), fine = roomBy(scene, 64, 64);
    const auto light = [](const Receivers& receivers, size_t i) {
        return vec3(2.0f + static_cast<float>(receivers.materials[i])) +
               0.3f * receivers.positions[i];
    };
    const SplatBuffer splat = Upsampling(coarse, fine).of(splatOf(coarse, light), {}).splat;
    int wrong = 0;
    for (size_t i = 0; i < fine.positions.size(); ++i) {
        if (fine.seen(i)) {
            const vec4& sum = splat.irradiance.pixels[i];
            wrong += glm::length(vec3(sum) / sum.w - light(fine, i)) > 0.1f ? 1 : 0;
        }
    }
    // Details that no pixel of the coarse image sees.
    EXPECT_LT(wrong, 64 * 64 / 100);
}

// A floor inlaid with another metal, and a thin bar of it before nothing: what rays find is
// reflected in each pixel's own colour.
TEST(Upsampling, ReflectionsHaveTheColourOfEachPixel) {
    Scene scene;
    const uint32_t red = addMaterial(scene, glossyParams(vec3(0.9f, 0.1f, 0.1f), 1.0f, 0.05f));
    const uint32_t blue = addMaterial(scene, glossyParams(vec3(0.1f, 0.1f, 0.9f), 1.0f, 0.05f));
    addQuad(scene, vec3(-1, 0, 0), vec3(1, 0, 0), vec3(0, 0.4f, 0), red);
    addQuad(scene, vec3(0, 0, 0), vec3(1, 0, 0), vec3(0, 0.4f, 0), blue);
    addQuad(scene, vec3(-0.02f, 0.4f, 0), vec3(0.04f, 0, 0), vec3(0, 0.6f, 0), blue);
    scene.cameras.push_back(lookAt(vec3(0, 0.5f, 2), vec3(0, 0, -1)));
    const Receivers coarse = roomBy(scene, 24, 24), fine = roomBy(scene, 96, 96);
    ASSERT_TRUE(coarse.anyByRays());
    const vec3 light(2.0f);
    Image<vec3> by_rays(24, 24);
    for (size_t i = 0; i < by_rays.pixels.size(); ++i) {
        by_rays.pixels[i] = coarse.seen(i) ? light * coarse.specularAlbedo(i) : vec3(0.0f);
    }
    const SplatBuffer splat =
        splatOf(coarse, [&](const Receivers&, size_t) { return kPi * light; });
    const Upsampling::Light found = Upsampling(coarse, fine).of(splat, by_rays);
    int seen = 0;
    for (size_t i = 0; i < fine.positions.size(); ++i) {
        if (fine.seen(i) && fine.by_rays[i] != 0) {
            ++seen;
            const vec3 expected = light * fine.specularAlbedo(i);
            EXPECT_LT(glm::length(found.by_rays.pixels[i] - expected), 1e-3f) << i;
        }
    }
    EXPECT_GT(seen, 500);
}

TEST(Upsampling, WhereThereAreNoRecordsThereIsNoLight) {
    const Scene scene = glossyRoom();
    const Receivers coarse = roomBy(scene, 8, 8), fine = roomBy(scene, 16, 16);
    SplatBuffer none;
    none.irradiance = Image<vec4>(8, 8);
    for (const vec4& sum : Upsampling(coarse, fine).of(none, {}).splat.irradiance.pixels) {
        EXPECT_EQ(sum, vec4(0.0f));
    }
}

}  // namespace
}  // namespace sheen
