#include "scene/scene.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "core/error.h"

namespace sheen {

const Camera& findCamera(const Scene& scene, const std::string& name) {
    SHEEN_CHECK(!scene.cameras.empty());
    if (name.empty()) {
        return scene.cameras.front();
    }
    for (const Camera& camera : scene.cameras) {
        if (camera.name == name) {
            return camera;
        }
    }
    size_t index = 0;
    const char* end = name.data() + name.size();
    const auto [stop, error] = std::from_chars(name.data(), end, index);
    if (error == std::errc() && stop == end && index < scene.cameras.size()) {
        return scene.cameras[index];
    }
    std::string known;
    for (size_t i = 0; i < scene.cameras.size(); ++i) {
        known += fmt::format("{}{} ({})", i > 0 ? ", " : "", i, scene.cameras[i].name);
    }
    throwUsage("--camera {}: no such camera; the scene has {}", name, known);
}

CameraRay cameraRay(const Camera& camera, int width, int height, float x, float y) {
    const float tan_half = std::tan(0.5f * camera.y_fov);
    const float aspect = static_cast<float>(width) / static_cast<float>(height);
    const vec3 direction_camera(
        (2.0f * (x + 0.5f) / static_cast<float>(width) - 1.0f) * tan_half * aspect,
        (1.0f - 2.0f * (y + 0.5f) / static_cast<float>(height)) * tan_half, -1.0f);
    return {.origin = vec3(camera.world_from_camera[3]),
            .direction = glm::normalize(mat3(camera.world_from_camera) * direction_camera)};
}

MaterialParams materialAt(const Scene& scene, const Material& material, const vec2& uv) {
    MaterialParams params = material.params;
    if (material.base_color_texture >= 0) {
        const Texture& texture = scene.textures[static_cast<size_t>(material.base_color_texture)];
        const shared::TextureTaps taps =
            shared::textureTaps(uv, glm::ivec2(texture.width, texture.height), texture.wrap);
        const auto texel = [&](int x, int y) {
            return texture.texels[static_cast<size_t>(y) * texture.width + x];
        };
        const vec3 lower = glm::mix(texel(taps.lower.x, taps.lower.y),
                                    texel(taps.upper.x, taps.lower.y), taps.fraction.x);
        const vec3 upper = glm::mix(texel(taps.lower.x, taps.upper.y),
                                    texel(taps.upper.x, taps.upper.y), taps.fraction.x);
        params.base_color *= glm::mix(lower, upper, taps.fraction.y);
    }
    return params;
}

float surfaceOffset(const Scene& scene) {
    constexpr float kOffsetOverSize = 5e-6f;
    constexpr float kOffsetOverCoordinate = 0x1p-19f;  // 16 to 32 steps of a float
    const float size = scene.bounds.size();
    if (!(size > 0.0f)) {
        return kOffsetOverSize;
    }
    const vec3 farthest = glm::max(glm::abs(scene.bounds.lower), glm::abs(scene.bounds.upper));
    return std::max(kOffsetOverSize * size,
                    kOffsetOverCoordinate * std::max({farthest.x, farthest.y, farthest.z}));
}

vec3 geometricNormal(const Scene& scene, int triangle) {
    const uvec3& t = scene.triangles[static_cast<size_t>(triangle)];
    const vec3& p = scene.positions[t.x];
    return glm::normalize(glm::cross(scene.positions[t.y] - p, scene.positions[t.z] - p));
}

}  // namespace sheen
