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

CameraRay cameraRay(const Camera& camera, int part_width, int part_height, float part_x,
                    float part_y) {
    const ivec2 whole = camera.wholeSize({part_width, part_height});
    const auto width = static_cast<float>(whole.x);
    const auto height = static_cast<float>(whole.y);
    const float x = part_x + static_cast<float>(camera.window.first.x);
    const float y = part_y + static_cast<float>(camera.window.first.y);
    const float tan_half = std::tan(0.5f * camera.y_fov);
    const float aspect = width / height;
    const vec3 direction_camera((2.0f * (x + 0.5f) / width - 1.0f) * tan_half * aspect,
                                (1.0f - 2.0f * (y + 0.5f) / height) * tan_half, -1.0f);
    const vec3 way = mat3(camera.world_from_camera) * direction_camera;
    return {.origin = vec3(camera.world_from_camera[3]) + camera.near * way,
            .direction = glm::normalize(way)};
}

float pixelFootprint(const Camera& camera, int part_height, const vec3& position, const vec3& n_g) {
    const int height = camera.wholeSize({0, part_height}).y;
    const vec3 way = position - vec3(camera.world_from_camera[3]);
    const float distance = glm::length(way);
    if (!(distance > 0.0f)) {
        return 0.0f;
    }
    const float width = 2.0f * std::tan(0.5f * camera.y_fov) / static_cast<float>(height);
    const float along = std::abs(glm::dot(way, vec3(camera.world_from_camera[2]))) / distance;
    return shared::footprintArea(width * width * along * along * along, distance,
                                 glm::dot(n_g, way) / distance);
}

float surfaceOffset(const Scene& scene, uint32_t triangle, const vec3& position, const vec3& n_g,
                    float distance) {
    // A vertex as a ray has it, from the ray's origin, is off by half a unit in the last place of
    // the way there; dotted with the normal, which is off likewise, by a few of those. 64 units.
    constexpr float kUnits = 0x1p-17f;
    constexpr float kOfDistance = 0.25f;
    const uvec3& t = scene.triangles[triangle];
    const vec3 way = glm::max(glm::abs(scene.positions[t.x] - position),
                              glm::max(glm::abs(scene.positions[t.y] - position),
                                       glm::abs(scene.positions[t.z] - position)));
    return kUnits * (maxAbs(position) + glm::dot(glm::abs(n_g), way) + kOfDistance * distance);
}

float distanceToTriangle(const Scene& scene, uint32_t triangle, const vec3& p) {
    const uvec3& t = scene.triangles[triangle];
    const vec3 corners[] = {scene.positions[t.x] - p, scene.positions[t.y] - p,
                            scene.positions[t.z] - p};
    const vec3 normal = geometricNormal(scene, static_cast<int>(triangle));
    float nearest = kInfinity;
    bool above = true;  // within the prism over the triangle
    for (int i = 0; i < 3; ++i) {
        const vec3& a = corners[i];
        const vec3 edge = corners[(i + 1) % 3] - a;
        above = above && glm::dot(glm::cross(edge, normal), a) >= 0.0f;
        const float along = glm::clamp(-glm::dot(a, edge) / glm::dot(edge, edge), 0.0f, 1.0f);
        nearest = std::min(nearest, glm::length(a + along * edge));
    }
    return above ? std::abs(glm::dot(normal, corners[0])) : nearest;
}

vec3 barycentricOf(const Scene& scene, uint32_t triangle, const vec3& p) {
    const uvec3& t = scene.triangles[triangle];
    const dvec3 a(scene.positions[t.x]);
    const dvec3 ab = dvec3(scene.positions[t.y]) - a, ac = dvec3(scene.positions[t.z]) - a;
    const dvec3 n = glm::cross(ab, ac), way = dvec3(p) - a;
    const double v = glm::dot(glm::cross(way, ac), n) / glm::dot(n, n);
    const double w = glm::dot(glm::cross(ab, way), n) / glm::dot(n, n);
    return glm::clamp(vec3(1.0 - v - w, v, w), 0.0f, 1.0f);
}

vec3 geometricNormal(const Scene& scene, int triangle) {
    const uvec3& t = scene.triangles[static_cast<size_t>(triangle)];
    const vec3& p = scene.positions[t.x];
    return glm::normalize(glm::cross(scene.positions[t.y] - p, scene.positions[t.z] - p));
}

}  // namespace sheen
