#include "scene/defaults.h"

#include <algorithm>
#include <cmath>

namespace sheen {
namespace {

constexpr vec3 kUp(0.0f, 1.0f, 0.0f);

// Where the camera stands, seen from what it looks at, along the ground; of one that looks straight
// down or up, where its lower or upper edge is.
vec3 backAlongGround(const Camera& camera) {
    const mat3 axes(camera.world_from_camera);
    constexpr float kSteep = 1e-3f;
    vec3 back = axes[2] - axes[2].y * kUp;
    if (glm::length(back) < kSteep) {
        back = -std::copysign(1.0f, axes[2].y) * (axes[1] - axes[1].y * kUp);
    }
    return glm::normalize(back);
}

}  // namespace

Camera framingCamera(const Bounds& bounds) {
    Camera camera{.name = "default"};
    if (bounds.empty()) {
        return camera;
    }
    const vec3 back = glm::normalize(vec3(0.35f, 0.3f, 1.0f));
    const vec3 right = glm::normalize(glm::cross(kUp, back));
    const vec3 up = glm::cross(back, right);
    const float distance = 0.5f * bounds.size() / std::sin(0.5f * camera.y_fov);
    camera.world_from_camera = mat4(vec4(right, 0.0f), vec4(up, 0.0f), vec4(back, 0.0f),
                                    vec4(bounds.center() + distance * back, 1.0f));
    return camera;
}

bool isDark(const Scene& scene) {
    return scene.lights.empty() && scene.environment.empty() &&
           std::all_of(scene.materials_of.begin(), scene.materials_of.end(),
                       [&](uint32_t material) { return !scene.materials[material].emits(); });
}

PunctualLight keyLight(const Camera& camera) {
    const vec3 back = backAlongGround(camera);
    const vec3 left = glm::cross(back, kUp);
    PunctualLight light{};
    light.kind = shared::LIGHT_DIRECTIONAL;
    light.direction = -glm::normalize(kUp + 0.6f * back + 0.4f * left);
    light.intensity = vec3(kPi);
    light.spot_offset = 1.0f;
    light.cos_outer = -1.0f;
    return light;
}

}  // namespace sheen
