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

// Toward the key light, from where `back` points along the ground.
vec3 towardKey(const vec3& back) {
    const vec3 left = glm::cross(back, kUp);
    return glm::normalize(kUp + 0.6f * back + 0.4f * left);
}

// A soft box: broad, and fading toward its rim.
struct SoftBox {
    vec3 toward;
    float radius;    // radians
    float radiance;  // more than the sky's
};

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
    PunctualLight light{};
    light.kind = shared::LIGHT_DIRECTIONAL;
    light.direction = -towardKey(backAlongGround(camera));
    light.intensity = vec3(kPi);
    light.spot_offset = 1.0f;
    light.cos_outer = -1.0f;
    return light;
}

Environment studioSky(const Camera& camera) {
    // Radiances straight up, along the ground and straight down; how far down the floor begins.
    constexpr float kAbove = 0.7f;
    constexpr float kLevel = 0.4f;
    constexpr float kBelow = 0.15f;
    constexpr float kFloor = 0.25f;
    constexpr vec3 kBack(0, 0, 1);  // the image's own axes: cameras look along -z
    const SoftBox boxes[] = {{towardKey(kBack), 0.6f, 0.8f},
                             {glm::normalize(vec3(1.0f, 0.5f, -0.4f)), 0.5f, 0.6f}};
    Environment sky;
    sky.texels = Image<vec3>(64, 32);
    for (int y = 0; y < sky.texels.height; ++y) {
        for (int x = 0; x < sky.texels.width; ++x) {
            const vec2 size(sky.texels.width, sky.texels.height);
            const vec3 direction = sky.directionFromImage((vec2(x, y) + 0.5f) / size);
            const float ground = glm::smoothstep(0.0f, kFloor, -direction.y);
            float radiance = direction.y > 0.0f ? glm::mix(kLevel, kAbove, direction.y)
                                                : glm::mix(kLevel, kBelow, ground);
            for (const SoftBox& box : boxes) {
                const float angle =
                    std::acos(std::clamp(glm::dot(direction, box.toward), -1.0f, 1.0f));
                radiance += box.radiance * (1.0f - glm::smoothstep(0.6f, 1.0f, angle / box.radius));
            }
            sky.texels.at(x, y) = vec3(radiance);
        }
    }
    const vec3 back = backAlongGround(camera);
    sky.rotation = -std::atan2(-back.x, back.z);
    return sky;
}

}  // namespace sheen
