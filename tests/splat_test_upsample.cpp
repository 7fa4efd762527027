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

// Sums of two records' worth of weight.
template <class Light>
SplatBuffer splatOf(const Receivers& receivers, const Light& light) {
    constexpr float kWeightSum = 2.0f;
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
    const Upsampling upsampling(coarse, fine);
    const vec3 light(1.0f, 2.0f, 3.0f);
    const SplatBuffer splat =
        upsampling.of(splatOf(coarse, [&](const Receivers&, size_t) { return light; }));
    Image<vec3> constant(20, 15);
    constant.pixels.assign(constant.pixels.size(), light);
    const Image<vec3> of_rays = upsampling.of(constant);
    ASSERT_EQ(of_rays.width, 41);
    ASSERT_EQ(of_rays.height, 30);
    for (size_t i = 0; i < fine.positions.size(); ++i) {
        if (!fine.seen(i)) {
            EXPECT_EQ(splat.irradiance.pixels[i].w, 0.0f);
            continue;
        }
        const vec4& sum = splat.irradiance.pixels[i];
        ASSERT_GT(sum.w, 0.0f) << i;
        EXPECT_LT(glm::length(vec3(sum) / sum.w - light), 1e-5f);
        EXPECT_LT(glm::length(vec3(splat.specular.pixels[i]) / sum.w - 0.5f * light), 1e-5f);
        EXPECT_LT(glm::length(of_rays.pixels[i] - light), 1e-5f);
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
    const SplatBuffer splat = Upsampling(coarse, fine).of(splatOf(coarse, light));
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

TEST(Upsampling, WhereThereAreNoRecordsThereIsNoLight) {
    const Scene scene = glossyRoom();
    const Receivers coarse = roomBy(scene, 8, 8), fine = roomBy(scene, 16, 16);
    SplatBuffer none;
    none.irradiance = Image<vec4>(8, 8);
    const Upsampling upsampling(coarse, fine);
    for (const vec4& sum : upsampling.of(none).irradiance.pixels) {
        EXPECT_EQ(sum, vec4(0.0f));
    }
    for (const vec3& light : upsampling.of(Image<vec3>()).pixels) {
        EXPECT_EQ(light, vec3(0.0f));
    }
}

}  // namespace
}  // namespace sheen
