// What arrives in rooms whose bounces are known.
#pragma once

#include <cmath>
#include <vector>

#include "light/outgoing.h"
#include "rays/jitter.h"
#include "test_scenes.h"

namespace sheen {

// What arrives from all around, mean over 1024 directions of cones as wide as records' rays.
inline vec3 meanRadiance(const OutgoingLight& light, const vec3& eye) {
    constexpr int kCount = 1024;
    std::vector<vec3> directions;
    for (uint32_t i = 0; i < kCount; ++i) {
        const vec2 u = randomPlace(i, 7);
        const float z = 2.0f * u.x - 1.0f;
        const float r = std::sqrt(1.0f - z * z);
        directions.push_back(
            glm::normalize(vec3(r * std::cos(2 * kPi * u.y), r * std::sin(2 * kPi * u.y), z)));
    }
    const std::vector<float> solid_angles(kCount, 0.01f);
    std::vector<vec4> seen(kCount);
    light.cast({.origin = eye, .directions = directions, .solid_angles = solid_angles},
               seen.data());
    vec3 sum(0.0f);
    for (const vec4& s : seen) {
        sum += vec3(s);
    }
    return sum / static_cast<float>(kCount);
}

// A diffuse sphere with a light at its centre: every bounce arrives alike everywhere, a constant
// share of the one before.
inline Scene sphereRoom(float albedo) {
    Scene scene;
    addSphere(scene, vec3(0.0f), 2.0f, 48, addMaterial(scene, diffuseParams(vec3(albedo))));
    scene.lights.push_back(pointLight(vec3(0.0f), vec3(3.0f)));
    return scene;
}

}  // namespace sheen
