// References of small scenes.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "reference/reference.h"
#include "test_scenes.h"

namespace sheen {

/// All channels of all pixels lie within `sigmas` standard errors, plus a share `bias` of the value
/// that the comparison itself cannot resolve.
inline void expectWithin(const Image<vec3>& values, const Image<vec3>& variance,
                         const std::function<vec3(int)>& expected, double sigmas, double bias) {
    ASSERT_EQ(values.count(), variance.count());
    for (int i = 0; i < values.count(); ++i) {
        const vec3 truth = expected(i);
        for (int c = 0; c < 3; ++c) {
            const auto pixel = static_cast<size_t>(i);
            const double error = std::abs(values.pixels[pixel][c] - truth[c]);
            EXPECT_LE(error, sigmas * std::sqrt(variance.pixels[pixel][c]) + bias * truth[c])
                << "pixel " << i << " channel " << c << " expected " << truth[c];
        }
    }
}

/// 64 pixels x 3 channels from 16 replicates each (Student's t with 15 degrees of freedom): 7
/// standard errors are exceeded by chance once in a thousand runs of such a test.
constexpr double kSigmas = 7.0;

/// A lit room with a glossy box in it whose faces look inward.
inline Scene litRoom() {
    Scene scene;
    const uint32_t white = addMaterial(scene, diffuseParams(vec3(0.7f)));
    const uint32_t red = addMaterial(scene, diffuseParams(vec3(0.6f, 0.1f, 0.1f)));
    const uint32_t plastic = addMaterial(scene, glossyParams(vec3(0.5f), 0.0f, 0.4f));
    const uint32_t metal = addMaterial(scene, glossyParams(vec3(0.9f, 0.8f, 0.6f), 1.0f, 0.3f));
    const uint32_t lamp = addMaterial(scene, diffuseParams(vec3(0.5f), vec3(4.0f)));
    addBox(scene, vec3(-1), vec3(1), {red, white, plastic, white, white, white}, true);
    addBox(scene, vec3(-0.6f, -1.0f, -0.5f), vec3(0.1f, -0.3f, 0.2f), metal, true);
    addQuad(scene, vec3(0.3f, 0.99f, -0.2f), vec3(0.4f, 0, 0), vec3(0, 0, 0.4f), lamp);
    scene.lights.push_back(pointLight(vec3(0.5f, 0.4f, 0.6f), vec3(1.0f)));
    scene.cameras.push_back(lookAt(vec3(0.2f, 0.1f, 0.95f), vec3(-0.2f, -0.6f, -0.2f)));
    return scene;
}

inline ReferenceParams smallParams(const Camera& camera, int size, int spp) {
    return {
        .width = size, .height = size, .camera = camera, .bounces = 1, .spp = spp, .quiet = true};
}

inline ReferenceParams smallParams(const Scene& scene, int size, int spp) {
    return smallParams(scene.cameras.front(), size, spp);
}

/// What the camera sees and its direct light, no bounce.
inline Frame firstHits(const Scene& scene, int width, int height) {
    return renderReference(scene, {.width = width,
                                   .height = height,
                                   .camera = scene.cameras.front(),
                                   .bounces = 0,
                                   .spp = 2,
                                   .replicates = 2,
                                   .quiet = true})
        .frame;
}

}  // namespace sheen
