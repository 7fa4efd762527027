// Tangents for normal maps, of meshes whose file has none.
#include <cmath>
#include <map>

#include "scene/gltf_parts.h"

namespace sheen::gltf {
namespace {

// Along growing u in a triangle's plane; zero where the coordinates have no area. Maps say what
// leans along u, and up in the image, where v falls: mirrored is what turns this frame over.
struct UvAxes {
    vec3 u{0.0f};
    bool mirrored = false;
};

UvAxes axesOf(const Scene& scene, const uvec3& t, const TextureUse& use) {
    const std::vector<vec2>& uvs = use.uv_set == 1 ? scene.second_uvs : scene.uvs;
    if (uvs.empty()) {
        return {};
    }
    const auto uv = [&](uint32_t vertex) {
        return shared::transformedUv(use.transform, uvs[vertex]);
    };
    const vec2 d1 = uv(t.y) - uv(t.x);
    const vec2 d2 = uv(t.z) - uv(t.x);
    const float area2 = d1.x * d2.y - d1.y * d2.x;
    if (area2 == 0.0f || !std::isfinite(area2)) {
        return {};
    }
    const vec3 e1 = scene.positions[t.y] - scene.positions[t.x];
    const vec3 e2 = scene.positions[t.z] - scene.positions[t.x];
    return {.u = (d2.y * e1 - d1.y * e2) * (area2 < 0.0f ? -1.0f : 1.0f), .mirrored = area2 > 0.0f};
}

float angleAt(const Scene& scene, const uvec3& t, int corner) {
    const vec3& p = scene.positions[t[corner]];
    const vec3 a = glm::normalize(scene.positions[t[(corner + 1) % 3]] - p);
    const vec3 b = glm::normalize(scene.positions[t[(corner + 2) % 3]] - p);
    return std::acos(glm::clamp(glm::dot(a, b), -1.0f, 1.0f));
}

// A unit vector across `n`, as `along` leads; any where it leads nowhere.
vec3 across(const vec3& along, const vec3& n) {
    const vec3 side = along - n * glm::dot(n, along);
    const float length = glm::length(side);
    if (length > 1e-12f && std::isfinite(length)) {
        return side / length;
    }
    const vec3 helper = std::abs(n.x) < 0.5f ? vec3(1, 0, 0) : vec3(0, 1, 0);
    return glm::normalize(helper - n * glm::dot(n, helper));
}

template <class T>
void appendCopy(std::vector<T>& values, uint32_t of) {
    if (!values.empty()) {
        const T value = values[of];
        values.push_back(value);
    }
}

}  // namespace

void makeTangents(Scene& scene, size_t first_triangle) {
    scene.tangents.resize(scene.positions.size(), vec4(0.0f));
    std::map<uint32_t, uint32_t> mirrored;  // twins of vertices, for mirrored triangles
    for (size_t i = first_triangle; i < scene.triangles.size(); ++i) {
        uvec3& t = scene.triangles[i];
        const TextureUse& use = scene.materials[scene.materials_of[i]].tangentTexture();
        const UvAxes axes = axesOf(scene, t, use);
        for (int corner = 0; corner < 3; ++corner) {
            if (axes.mirrored) {
                const auto [twin, is_new] =
                    mirrored.try_emplace(t[corner], static_cast<uint32_t>(scene.positions.size()));
                if (is_new) {
                    appendCopy(scene.positions, t[corner]);
                    appendCopy(scene.normals, t[corner]);
                    appendCopy(scene.uvs, t[corner]);
                    appendCopy(scene.second_uvs, t[corner]);
                    appendCopy(scene.lightmap_uvs, t[corner]);
                    appendCopy(scene.colors, t[corner]);
                    scene.tangents.emplace_back(0.0f, 0.0f, 0.0f, -1.0f);
                }
                t[corner] = twin->second;
            }
            vec4& tangent = scene.tangents[t[corner]];
            const vec3& n = scene.normals[t[corner]];
            const vec3 u = axes.u == vec3(0.0f) ? axes.u : across(axes.u, n);
            tangent =
                vec4(vec3(tangent) + angleAt(scene, t, corner) * u, axes.mirrored ? -1.0f : 1.0f);
        }
    }
    for (size_t i = first_triangle; i < scene.triangles.size(); ++i) {
        for (int corner = 0; corner < 3; ++corner) {
            vec4& tangent = scene.tangents[scene.triangles[i][corner]];
            tangent =
                vec4(across(vec3(tangent), scene.normals[scene.triangles[i][corner]]), tangent.w);
        }
    }
}

}  // namespace sheen::gltf
