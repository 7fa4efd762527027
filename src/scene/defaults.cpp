#include "scene/defaults.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"

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

// Upright, looking back along a unit direction; straight down or up, with -z or z up in the image.
mat3 uprightAxes(const vec3& back) {
    constexpr float kSteep = 1e-4f;
    vec3 right = glm::cross(kUp, back);
    right = glm::length(right) > kSteep ? glm::normalize(right) : vec3(1.0f, 0.0f, 0.0f);
    return {right, glm::cross(back, right), back};
}

mat4 pose(const mat3& axes, const vec3& eye) {
    return mat4(vec4(axes[0], 0.0f), vec4(axes[1], 0.0f), vec4(axes[2], 0.0f), vec4(eye, 1.0f));
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

Camera framingCamera(const Scene& scene) {
    constexpr float kFilled = 0.9f;  // of the image's height
    const vec3 kBack = glm::normalize(vec3(0.7f, 0.45f, 1.0f));
    Camera camera{.name = "default"};
    if (scene.bounds.empty()) {
        return camera;
    }
    const mat3 axes = uprightAxes(kBack);
    // Of a pyramid from the eye, each side touches a point of the scene: the farthest in that
    // direction, and back, where the eye is.
    const float slope = kFilled * std::tan(0.5f * camera.y_fov);
    vec3 lower(kInfinity), upper(-kInfinity);
    for (const vec3& position : scene.positions) {
        const vec3 p = (position - scene.bounds.center()) * axes;
        lower = glm::min(lower, vec3(p.x - slope * p.z, p.y - slope * p.z, p.z));
        upper = glm::max(upper, vec3(p.x + slope * p.z, p.y + slope * p.z, p.z));
    }
    const vec3 middle = 0.5f * (lower + upper);
    const vec3 half = 0.5f * (upper - lower);
    // All of it lies before the eye, however flat it is.
    const float distance =
        std::max(std::max(half.x, half.y) / slope, upper.z + 0.01f * scene.bounds.size());
    camera.world_from_camera =
        pose(axes, scene.bounds.center() + axes * vec3(middle.x, middle.y, distance));
    return camera;
}

Camera seenFrom(const Scene& scene, const LoadParams& params) {
    const Viewpoint& view = params.view;
    Camera camera = findCamera(scene, params.camera);
    camera.name = "view";
    const vec3 eye = view.at ? vec3(*view.at - scene.origin) : vec3(camera.world_from_camera[3]);
    if (view.at || view.look_at) {
        const vec3 back =
            eye - (view.look_at ? vec3(*view.look_at - scene.origin) : scene.bounds.center());
        if (!(glm::length(back) > 0.0f)) {
            throwUsage("--camera-at, --look-at: both are one point; name another");
        }
        camera.world_from_camera = pose(uprightAxes(glm::normalize(back)), eye);
        camera.near = 0.0f;
    }
    camera.y_fov = view.y_fov.value_or(camera.y_fov);
    return camera;
}

bool isDark(const Scene& scene) {
    return !scene.lightmapped && scene.lights.empty() && scene.environment.empty() &&
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
