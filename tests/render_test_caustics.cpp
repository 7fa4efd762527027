// Caustics in a layer of their own: by photons as by the path tracer, and no light counted twice.
#include <gtest/gtest.h>

#include <cmath>

#include "metrics/compare.h"
#include "test_reference.h"
#include "test_render.h"

namespace sheen {
namespace {

constexpr int kSize = 32;
// Of a room like this one 30,000 photons are 21% off, 300,000 6% (docs/decisions/light.md).
// Indirect light, measured here: 1.2 to 2.2%, bias 0.3 to 0.5%.
constexpr double kCausticRmse = 0.12, kCausticBias = 0.02;
constexpr double kIndirectRmse = 0.06, kIndirectBias = 0.015;

// A room with a lamp, a mirror on a wall and a ball of smooth metal. Where it is glossy, its floor
// has a lobe that rays follow.
Scene roomWithMirror(const MaterialParams& floor) {
    Scene scene;
    const uint32_t white = addMaterial(scene, diffuseParams(vec3(0.6f)));
    const uint32_t ground = addMaterial(scene, floor);
    const uint32_t mirror = addMaterial(scene, glossyParams(vec3(0.9f), 1.0f, 0.0f));
    const uint32_t metal = addMaterial(scene, glossyParams(vec3(0.9f, 0.8f, 0.6f), 1.0f, 0.3f));
    const uint32_t lamp = addMaterial(scene, diffuseParams(vec3(0.0f), vec3(4.0f)));
    addBox(scene, vec3(-1), vec3(1), {white, white, ground, white, white, white}, true);
    addQuad(scene, vec3(-0.98f, -0.8f, -0.6f), vec3(0, 1.4f, 0), vec3(0, 0, 1.2f), mirror);
    addSphere(scene, vec3(0.4f, -0.7f, -0.3f), 0.3f, 24, metal);
    addQuad(scene, vec3(-0.5f, 0.9f, -0.5f), vec3(1.0f, 0, 0), vec3(0, 0, 1.0f), lamp);
    scene.cameras.push_back(lookAt(vec3(0.2f, 0.1f, 0.95f), vec3(0.0f, -0.6f, -0.3f)));
    return scene;
}

struct Means {
    double caustic = 0.0;
    double indirect = 0.0;
};
Means meansOf(const Frame& frame) {
    Means means;
    for (size_t i = 0; i < frame.caustic.pixels.size(); ++i) {
        means.caustic += luminance(frame.caustic.pixels[i]);
        means.indirect += luminance(frame.indirect.pixels[i]);
    }
    return means;
}

Comparison compare(const Image<vec3>& test, const Image<vec3>& truth, const Image<vec3>& variance) {
    return compareImages({.test = test, .reference = truth, .reference_variance = &variance});
}

// Of pixels that are not specular: what mirrors show of highlights is another matter.
Image<vec3> rest(const Frame& frame, Image<vec3> layer) {
    for (size_t i = 0; i < layer.pixels.size(); ++i) {
        const float alpha = shared::alphaFromRoughness(frame.roughness.pixels[i]);
        layer.pixels[i] *= alpha < kSpecularAlpha ? 0.0f : 1.0f;
    }
    return layer;
}

void expectAlike(const Scene& scene, int bounces) {
    ReferenceParams of_truth = smallParams(scene, kSize, 512);
    of_truth.bounces = bounces;
    of_truth.caustics_apart = true;
    const Frame truth = renderReference(scene, of_truth).frame;
    RenderParams params = smallRender(kSize, kSize);
    params.bounces = bounces;
    params.caustics = 100'000;
    const Frame frame = renderFrame(scene, params).frame;
    const Comparison caustic = compare(frame.caustic, truth.caustic, truth.caustic_variance);
    EXPECT_LT(caustic.rel_rmse, kCausticRmse);
    EXPECT_LT(std::abs(caustic.bias), kCausticBias);
    const Comparison indirect = compare(rest(truth, frame.indirect), rest(truth, truth.indirect),
                                        rest(truth, truth.indirect_variance));
    EXPECT_LT(indirect.rel_rmse, kIndirectRmse);
    EXPECT_LT(std::abs(indirect.bias), kIndirectBias);
    // What is told apart is a good part of it.
    const Means means = meansOf(truth);
    EXPECT_GT(means.caustic, 0.03 * means.indirect);
}

TEST(CausticLayer, IsThatOfTheReference) {
    expectAlike(roomWithMirror(diffuseParams(vec3(0.5f))), kAllBounces);
}

TEST(CausticLayer, IsThatOfTheReferenceOnAGlossyFloor) {
    expectAlike(roomWithMirror(glossyParams(vec3(0.3f), 0.0f, 0.6f)), 1);
}

// With and without a layer of their own the reference's light is the same.
TEST(CausticLayer, TakesFromTheIndirectLightWhatItHolds) {
    const Scene scene = roomWithMirror(diffuseParams(vec3(0.5f)));
    ReferenceParams params = smallParams(scene, kSize, 64);
    params.bounces = kAllBounces;
    const Frame whole = renderReference(scene, params).frame;
    EXPECT_TRUE(whole.caustic.empty());
    params.caustics_apart = true;
    const Frame apart = renderReference(scene, params).frame;
    for (size_t i = 0; i < whole.indirect.pixels.size(); ++i) {
        const vec3 sum = apart.indirect.pixels[i] + apart.caustic.pixels[i];
        for (int c = 0; c < 3; ++c) {
            EXPECT_NEAR(sum[c], whole.indirect.pixels[i][c],
                        1e-4f * std::max(whole.indirect.pixels[i][c], 1e-3f));
            EXPECT_NEAR(apart.global_variance.pixels[i][c], whole.indirect_variance.pixels[i][c],
                        1e-2f * whole.indirect_variance.pixels[i][c] + 1e-9f);
        }
    }
}

// No layer, no photon and no other light where nothing is specular.
TEST(CausticLayer, CostsNothingWithoutSpecularSurfaces) {
    Scene scene = roomWithMirror(diffuseParams(vec3(0.5f)));
    for (Material& material : scene.materials) {
        material.params.roughness = std::max(material.params.roughness, 0.5f);
    }
    RenderParams params = smallRender(16, 16);
    const Frame without = renderFrame(scene, params).frame;
    params.caustics = 100'000;
    const RenderResult with = renderFrame(scene, params);
    EXPECT_TRUE(with.frame.caustic.empty());
    EXPECT_EQ(with.stats.caustic_photons, 0u);
    constexpr float kRounding = 1e-5f;
    for (size_t i = 0; i < without.indirect.pixels.size(); ++i) {
        const float light = without.indirect.pixels[i].y;
        EXPECT_NEAR(with.frame.indirect.pixels[i].y, light, kRounding * light);
    }
}

// Samples of edges see caustics as their pixels do.
TEST(CausticLayer, IsSmoothAtEdges) {
    const Scene scene = roomWithMirror(diffuseParams(vec3(0.5f)));
    RenderParams params = smallRender(kSize, kSize);
    params.caustics = 20'000;
    const RenderResult middles = renderFrame(scene, params);
    params.aa = 4;
    const RenderResult smooth = renderFrame(scene, params);
    ASSERT_GT(smooth.stats.pixels_edges, 0);
    const Means a = meansOf(middles.frame), b = meansOf(smooth.frame);
    EXPECT_NEAR(b.caustic, a.caustic, 0.03 * a.caustic);
}

}  // namespace
}  // namespace sheen
