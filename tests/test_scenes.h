// Small scenes built in code, cameras and images of rays, for the tests of the renderer's stages.
#pragma once

#include <array>
#include <cmath>
#include <random>

#include "scene/scene.h"

namespace sheen {

inline MaterialParams diffuseParams(const vec3& albedo, const vec3& emission = vec3(0.0f)) {
    return {.base_color = albedo,
            .metallic = 0.0f,
            .specular_color = vec3(1.0f),
            .specular = 0.0f,
            .emission = emission,
            .roughness = 1.0f,
            .film = vec3(0.0f),
            .transmission = 0.0f};
}

inline MaterialParams glossyParams(const vec3& base, float metallic, float roughness,
                                   const vec3& emission = vec3(0.0f)) {
    return {.base_color = base,
            .metallic = metallic,
            .specular_color = vec3(1.0f),
            .specular = 1.0f,
            .emission = emission,
            .roughness = roughness,
            .film = vec3(0.0f),
            .transmission = 0.0f};
}

inline uint32_t addMaterial(Scene& scene, const MaterialParams& params) {
    Material material;
    material.name = std::to_string(scene.materials.size());
    material.params = params;
    scene.materials.push_back(material);
    return static_cast<uint32_t>(scene.materials.size() - 1);
}

/// Texels in linear light, [y][x], rounded to 16 bits. The texture's index.
inline int addTexture(Scene& scene, int width, int height, const std::vector<vec3>& texels,
                      int wrap = shared::WRAP_REPEAT) {
    TextureImage image;
    image.width = width;
    image.height = height;
    for (const vec3& texel : texels) {
        for (const float value : {texel.x, texel.y, texel.z, 1.0f}) {
            image.words.push_back(static_cast<uint16_t>(std::lround(65535.0f * value)));
        }
    }
    makeSmaller(image, false);
    scene.images.push_back(image);
    Texture texture;
    texture.image = static_cast<int>(scene.images.size()) - 1;
    texture.wrap = glm::ivec2(wrap);
    scene.textures.push_back(texture);
    return static_cast<int>(scene.textures.size()) - 1;
}

inline uint32_t addVertex(Scene& scene, const vec3& p, const vec3& n) {
    scene.positions.push_back(p);
    scene.normals.push_back(n);
    scene.uvs.emplace_back(0.0f);
    scene.bounds.add(p);
    return static_cast<uint32_t>(scene.positions.size() - 1);
}

/// A parallelogram with corner p that faces cross(u, v).
inline void addQuad(Scene& scene, const vec3& p, const vec3& u, const vec3& v, uint32_t material) {
    const vec3 n = glm::normalize(glm::cross(u, v));
    const uint32_t base = addVertex(scene, p, n);
    addVertex(scene, p + u, n);
    addVertex(scene, p + u + v, n);
    addVertex(scene, p + v, n);
    scene.triangles.emplace_back(base, base + 1, base + 2);
    scene.triangles.emplace_back(base, base + 2, base + 3);
    scene.materials_of.insert(scene.materials_of.end(), 2, material);
}

/// The six faces of a box, normals inward (sign 1) or outward (-1), in the order -x +x -y +y -z +z.
inline void addBox(Scene& scene, const vec3& lower, const vec3& upper,
                   const std::array<uint32_t, 6>& m, bool inward) {
    const vec3 d = upper - lower;
    const vec3 dx(d.x, 0, 0), dy(0, d.y, 0), dz(0, 0, d.z);
    const auto quad = [&](const vec3& p, const vec3& u, const vec3& v, uint32_t material) {
        inward ? addQuad(scene, p, u, v, material) : addQuad(scene, p, v, u, material);
    };
    quad(lower, dy, dz, m[0]);
    quad(lower + dx, dz, dy, m[1]);
    quad(lower, dz, dx, m[2]);
    quad(lower + dy, dx, dz, m[3]);
    quad(lower, dx, dy, m[4]);
    quad(lower + dz, dy, dx, m[5]);
}

inline void addBox(Scene& scene, const vec3& lower, const vec3& upper, uint32_t material,
                   bool inward) {
    addBox(scene, lower, upper, {material, material, material, material, material, material},
           inward);
}

/// A sphere of 2 rings x rings patches; smooth normals outward, whichever side is looked at.
inline void addSphere(Scene& scene, const vec3& center, float radius, int rings,
                      uint32_t material) {
    const int sectors = 2 * rings;
    const auto base = static_cast<uint32_t>(scene.positions.size());
    for (int i = 0; i <= rings; ++i) {
        const float theta = kPi * static_cast<float>(i) / static_cast<float>(rings);
        for (int j = 0; j <= sectors; ++j) {
            const float phi = kPi * static_cast<float>(j) / static_cast<float>(rings);
            const vec3 n(std::sin(theta) * std::cos(phi), std::cos(theta),
                         std::sin(theta) * std::sin(phi));
            addVertex(scene, center + radius * n, n);
        }
    }
    const auto index = [&](int i, int j) {
        return base + static_cast<uint32_t>(i * (sectors + 1) + j);
    };
    for (int i = 0; i < rings; ++i) {
        for (int j = 0; j < sectors; ++j) {
            if (i > 0) {
                scene.triangles.emplace_back(index(i, j), index(i, j + 1), index(i + 1, j + 1));
                scene.materials_of.push_back(material);
            }
            if (i + 1 < rings) {
                scene.triangles.emplace_back(index(i, j), index(i + 1, j + 1), index(i + 1, j));
                scene.materials_of.push_back(material);
            }
        }
    }
}

inline PunctualLight pointLight(const vec3& position, const vec3& intensity) {
    return {.position = position,
            .inverse_range = 0.0f,
            .direction = vec3(0, -1, 0),
            .spot_scale = 0.0f,
            .intensity = intensity,
            .spot_offset = 1.0f,
            .kind = shared::LIGHT_POINT,
            .first_view = 0,
            .cos_outer = -1.0f,
            .view_tiles = 1};
}

inline PunctualLight directionalLight(const vec3& direction, const vec3& illuminance) {
    PunctualLight light = pointLight(vec3(0.0f), illuminance);
    light.kind = shared::LIGHT_DIRECTIONAL;
    light.direction = glm::normalize(direction);
    return light;
}

/// Cone angles from the axis, radians; the attenuation of KHR_lights_punctual.
inline PunctualLight spotLight(const vec3& position, const vec3& direction, const vec3& intensity,
                               float inner, float outer) {
    PunctualLight light = pointLight(position, intensity);
    light.kind = shared::LIGHT_SPOT;
    light.direction = glm::normalize(direction);
    light.cos_outer = std::cos(outer);
    light.spot_scale = 1.0f / std::max(std::cos(inner) - std::cos(outer), 1e-3f);
    light.spot_offset = -std::cos(outer) * light.spot_scale;
    return light;
}

inline Camera lookAt(const vec3& eye, const vec3& target) {
    const vec3 back = glm::normalize(eye - target);
    const vec3 up = std::abs(back.y) < 0.99f ? vec3(0, 1, 0) : vec3(0, 0, 1);
    const vec3 right = glm::normalize(glm::cross(up, back));
    Camera camera;
    camera.name = "camera";
    camera.world_from_camera = mat4(vec4(right, 0.0f), vec4(glm::cross(back, right), 0.0f),
                                    vec4(back, 0.0f), vec4(eye, 1.0f));
    return camera;
}

/// A room open to none, a box and a sphere in it, one point light. The floor is `floor`'s material.
inline Scene cornellRoom(const MaterialParams& floor, const MaterialParams& box) {
    Scene scene;
    const uint32_t white = addMaterial(scene, diffuseParams(vec3(0.7f)));
    const uint32_t red = addMaterial(scene, diffuseParams(vec3(0.6f, 0.1f, 0.1f)));
    const uint32_t green = addMaterial(scene, diffuseParams(vec3(0.1f, 0.5f, 0.1f)));
    const uint32_t ground = addMaterial(scene, floor);
    const uint32_t block = addMaterial(scene, box);
    addBox(scene, vec3(-1), vec3(1), {red, green, ground, white, white, white}, true);
    addBox(scene, vec3(-0.6f, -1.0f, -0.5f), vec3(0.0f, -0.4f, 0.1f), block, false);
    addSphere(scene, vec3(0.45f, -0.7f, -0.1f), 0.3f, 16, white);
    scene.lights.push_back(pointLight(vec3(0.2f, 0.7f, 0.3f), vec3(1.0f, 0.9f, 0.8f)));
    scene.cameras.push_back(lookAt(vec3(0.1f, 0.1f, 0.95f), vec3(0.0f, -0.5f, -0.3f)));
    return scene;
}

/// The same with a plastic floor and a metal box.
inline Scene glossyRoom(float floor_roughness = 0.4f, float box_roughness = 0.35f) {
    return cornellRoom(glossyParams(vec3(0.5f), 0.0f, floor_roughness),
                       glossyParams(vec3(0.9f, 0.7f, 0.4f), 1.0f, box_roughness));
}

/// The scene enlarged by s: lengths by s, intensities (candela) by s^2, so that radiance stays.
inline Scene scaled(Scene scene, float s) {
    for (vec3& p : scene.positions) {
        p *= s;
    }
    for (PunctualLight& light : scene.lights) {
        light.position *= s;
        light.intensity *= light.kind == shared::LIGHT_DIRECTIONAL ? 1.0f : s * s;
        light.inverse_range /= s;
    }
    for (Camera& camera : scene.cameras) {
        camera.world_from_camera[3] = vec4(s * vec3(camera.world_from_camera[3]), 1.0f);
    }
    scene.bounds = {.lower = s * scene.bounds.lower, .upper = s * scene.bounds.upper};
    return scene;
}

/// A source of reproducible numbers and directions.
class Random {
  public:
    explicit Random(uint32_t seed) : engine_(seed) {}
    float uniform(float low, float high) {
        return std::uniform_real_distribution<float>(low, high)(engine_);
    }
    vec3 direction() {
        const float z = uniform(-1.0f, 1.0f);
        const float phi = uniform(0.0f, 2.0f * kPi);
        const float r = std::sqrt(std::max(0.0f, 1.0f - z * z));
        return {r * std::cos(phi), r * std::sin(phi), z};
    }
    vec3 direction(const vec3& pole) {
        const vec3 d = direction();
        return glm::dot(d, pole) < 0.0f ? -d : d;
    }
    vec3 point(float low, float high) {
        const float x = uniform(low, high);
        const float y = uniform(low, high);
        return {x, y, uniform(low, high)};
    }
    /// A rotation matrix.
    mat3 rotation() {
        const vec3 x = direction();
        const vec3 y = glm::normalize(glm::cross(x, direction()));
        return {x, y, glm::cross(x, y)};
    }

  private:
    std::mt19937 engine_;
};

}  // namespace sheen
