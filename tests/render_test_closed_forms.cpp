// All bounces against closed forms: of whole renders, and of the reference.
#include <gtest/gtest.h>

#include "test_reference.h"
#include "test_render.h"

namespace sheen {
namespace {

constexpr int kSize = 24;

double meanOf(const Image<vec3>& layer) {
    double sum = 0.0;
    for (const vec3& light : layer.pixels) {
        sum += light.y;
    }
    return sum / static_cast<double>(layer.pixels.size());
}

RenderParams allBounces() {
    RenderParams params = smallRender(kSize, kSize);
    params.bounces = kAllBounces;
    return params;
}

ReferenceParams allPaths(const Scene& scene, int spp) {
    ReferenceParams params = smallParams(scene, kSize, spp);
    params.bounces = kAllBounces;
    return params;
}

// A white ball of radius 2 around a black one that shines: each bounce brings 0.9 of the one
// before, less what the lamp stops.
TEST(ClosedForms, AWhiteRoomWithOneLamp) {
    constexpr float kAlbedo = 0.9f, kRadius = 2.0f, kLamp = 0.1f, kRadiance = 10.0f;
    Scene scene;
    addSphere(scene, vec3(0.0f), kRadius, 48, addMaterial(scene, diffuseParams(vec3(kAlbedo))));
    addSphere(scene, vec3(0.0f), kLamp, 12,
              addMaterial(scene, diffuseParams(vec3(0.0f), vec3(kRadiance))));
    scene.cameras.push_back(lookAt(vec3(0.0f, 0.5f, 0.3f), vec3(0.0f, 2.0f, 0.5f)));
    const double share = (kLamp / kRadius) * (kLamp / kRadius);
    const double stays = kAlbedo * (1.0 - share);
    // But for facets: of the lamp's area, which 12 rings lack 2.5% of, direct light tells.
    const RenderResult cached = renderFrame(scene, allBounces());
    const double direct = meanOf(cached.frame.direct);
    EXPECT_NEAR(direct, kAlbedo * kRadiance * share, 0.04 * kAlbedo * kRadiance * share);
    const double expected = direct * stays / (1.0 - stays);
    EXPECT_NEAR(meanOf(cached.frame.indirect), expected, 0.01 * expected);
    const Frame traced = renderReference(scene, allPaths(scene, 256)).frame;
    EXPECT_NEAR(meanOf(traced.indirect), expected, 0.01 * expected);
}

// Two wide plates face each other; the upper one shines, and both reflect.
TEST(ClosedForms, TwoParallelPlates) {
    constexpr float kHalf = 60.0f, kUpper = 0.5f, kLower = 0.8f;
    Scene scene;
    const uint32_t lower = addMaterial(scene, diffuseParams(vec3(kLower)));
    const uint32_t upper = addMaterial(scene, diffuseParams(vec3(kUpper), vec3(1.0f)));
    addQuad(scene, vec3(-kHalf, 0, -kHalf), vec3(0, 0, 2 * kHalf), vec3(2 * kHalf, 0, 0), lower);
    addQuad(scene, vec3(-kHalf, 1, -kHalf), vec3(2 * kHalf, 0, 0), vec3(0, 0, 2 * kHalf), upper);
    scene.cameras.push_back(lookAt(vec3(0.1f, 0.9f, 0.0f), vec3(0.0f, 0.0f, 0.1f)));
    const double both = kUpper * kLower;
    const double expected = kLower * both / (1.0 - both);
    const Frame traced = renderReference(scene, allPaths(scene, 256)).frame;
    EXPECT_NEAR(meanOf(traced.direct), kLower, 0.01 * kLower);
    EXPECT_NEAR(meanOf(traced.indirect), expected, 0.01 * expected);
}

}  // namespace
}  // namespace sheen
