// The material at a point of a surface.
#include "scene/material.h"

#include <algorithm>
#include <cmath>

#include "scene/scene.h"

namespace sheen {
namespace {

float linearFromSrgb(float s) {
    return s <= 0.04045f ? s / 12.92f : std::pow((s + 0.055f) / 1.055f, 2.4f);
}

// Linear light, by what is stored.
std::vector<float> transferTable(size_t size, bool srgb) {
    std::vector<float> table(size);
    for (size_t i = 0; i < size; ++i) {
        const float stored = static_cast<float>(i) / static_cast<float>(size - 1);
        table[i] = srgb ? linearFromSrgb(stored) : stored;
    }
    return table;
}

// Bilinear, or the nearest.
vec4 sampled(const Scene& scene, const Texture& texture, const vec2& uv) {
    const TextureImage& image = scene.images[static_cast<size_t>(texture.image)];
    const glm::ivec2 size(image.width, image.height);
    if (texture.nearest) {
        const glm::ivec2 at = shared::nearestTaps(uv, size, texture.wrap).lower;
        return texelOf(image, texture.srgb, at.x, at.y);
    }
    const shared::TextureTaps taps = shared::textureTaps(uv, size, texture.wrap);
    const auto texel = [&](int x, int y) { return texelOf(image, texture.srgb, x, y); };
    const vec4 lower = glm::mix(texel(taps.lower.x, taps.lower.y),
                                texel(taps.upper.x, taps.lower.y), taps.fraction.x);
    const vec4 upper = glm::mix(texel(taps.lower.x, taps.upper.y),
                                texel(taps.upper.x, taps.upper.y), taps.fraction.x);
    return glm::mix(lower, upper, taps.fraction.y);
}

// Where each of a material's textures is looked up.
vec2 uvOf(const Scene& scene, uint32_t triangle, const vec3& barycentric, const TextureUse& use) {
    const uvec3& t = scene.triangles[triangle];
    const std::vector<vec2>& uvs = use.uv_set == 1 ? scene.second_uvs : scene.uvs;
    if (uvs.empty()) {
        return use.transform.offset;
    }
    return shared::transformedUv(
        use.transform,
        barycentric.x * uvs[t.x] + barycentric.y * uvs[t.y] + barycentric.z * uvs[t.z]);
}

vec4 texelAt(const Scene& scene, uint32_t triangle, const vec3& barycentric,
             const TextureUse& use) {
    return sampled(scene, scene.textures[static_cast<size_t>(use.texture)],
                   uvOf(scene, triangle, barycentric, use));
}

vec4 vertexColorAt(const Scene& scene, uint32_t triangle, const vec3& barycentric) {
    if (scene.colors.empty()) {
        return vec4(1.0f);
    }
    const uvec3& t = scene.triangles[triangle];
    return barycentric.x * scene.colors[t.x] + barycentric.y * scene.colors[t.y] +
           barycentric.z * scene.colors[t.z];
}

// How often a triangle's edges are divided so that the parts are about as large as the texels of
// its emission.
int emissionDivisions(const Scene& scene, uint32_t triangle, const TextureUse& use) {
    constexpr float kMost = 64.0f;
    const TextureImage& image =
        scene.images[static_cast<size_t>(scene.textures[static_cast<size_t>(use.texture)].image)];
    const vec2 origin = uvOf(scene, triangle, vec3(1, 0, 0), use);
    const vec2 size(image.width, image.height);
    const vec2 a = (uvOf(scene, triangle, vec3(0, 1, 0), use) - origin) * size;
    const vec2 b = (uvOf(scene, triangle, vec3(0, 0, 1), use) - origin) * size;
    const float longest = std::max({glm::length(a), glm::length(b), glm::length(b - a)});
    return static_cast<int>(std::ceil(std::clamp(longest, 1.0f, kMost)));
}

}  // namespace

vec4 texelOf(const TextureImage& image, bool srgb, int x, int y) {
    static const std::vector<float> of_bytes[] = {transferTable(256, false),
                                                  transferTable(256, true)};
    const size_t first = 4 * (static_cast<size_t>(y) * image.width + x);
    if (!image.bytes.empty()) {
        const uint8_t* stored = image.bytes.data() + first;
        const std::vector<float>& color = of_bytes[srgb ? 1 : 0];
        return {color[stored[0]], color[stored[1]], color[stored[2]], of_bytes[0][stored[3]]};
    }
    static const std::vector<float> of_words[] = {transferTable(65536, false),
                                                  transferTable(65536, true)};
    const uint16_t* stored = image.words.data() + first;
    const std::vector<float>& color = of_words[srgb ? 1 : 0];
    return {color[stored[0]], color[stored[1]], color[stored[2]], of_words[0][stored[3]]};
}

std::vector<vec4> linearTexels(const Scene& scene, const Texture& texture) {
    const TextureImage& image = scene.images[static_cast<size_t>(texture.image)];
    std::vector<vec4> texels;
    texels.reserve(image.texelCount());
    for (int y = 0; y < image.height; ++y) {
        for (int x = 0; x < image.width; ++x) {
            texels.push_back(texelOf(image, texture.srgb, x, y));
        }
    }
    return texels;
}

ShadingNormals normalsAt(const Scene& scene, uint32_t triangle, const vec3& barycentric,
                         const vec3& n_g, const vec3& wo) {
    const uvec3& t = scene.triangles[triangle];
    const auto interpolated = [&](const auto& values) {
        return barycentric.x * values[t.x] + barycentric.y * values[t.y] +
               barycentric.z * values[t.z];
    };
    const vec3 n = shared::interpolatedNormal(interpolated(scene.normals), n_g);
    ShadingNormals normals;
    normals.smooth = normals.mapped = shared::shadingNormal(n, n_g, wo);
    const Material& material = scene.materials[scene.materials_of[triangle]];
    if (material.normal_texture.used() && !scene.tangents.empty()) {
        normals.mapped =
            shared::mappedNormal(n, interpolated(scene.tangents),
                                 texelAt(scene, triangle, barycentric, material.normal_texture),
                                 material.normal_scale, n_g, wo);
    }
    return normals;
}

MaterialParams materialAt(const Scene& scene, uint32_t triangle, const vec3& barycentric) {
    const Material& material = scene.materials[scene.materials_of[triangle]];
    MaterialParams params = material.params;
    for (int use = 0; use < shared::TEXTURE_USES; ++use) {
        const TextureUse& texture = material.textures[static_cast<size_t>(use)];
        if (texture.used()) {
            params = shared::withTexel(params, use, texelAt(scene, triangle, barycentric, texture));
        }
    }
    if (!scene.colors.empty()) {
        params = shared::withVertexColor(params, vec3(vertexColorAt(scene, triangle, barycentric)),
                                         material.unlit);
    }
    return params;
}

bool maybeSpecular(const Scene& scene, const Material& material) {
    const MaterialParams& params = material.params;
    const auto is_smooth = [](float roughness) {
        return shared::alphaFromRoughness(roughness) < kSpecularAlpha;
    };
    if (material.unlit || (params.metallic == 0.0f && params.specular == 0.0f)) {
        return false;  // Lambertian
    }
    const TextureUse& texture = material.textures[shared::TEXTURE_METALLIC_ROUGHNESS];
    if (!texture.used()) {
        return is_smooth(params.roughness);
    }
    const std::vector<vec4> texels =
        linearTexels(scene, scene.textures[static_cast<size_t>(texture.texture)]);
    return std::any_of(texels.begin(), texels.end(), [&](const vec4& texel) {
        return is_smooth(
            shared::withTexel(params, shared::TEXTURE_METALLIC_ROUGHNESS, texel).roughness);
    });
}

bool anySpecular(const Scene& scene) {
    std::vector<bool> used(scene.materials.size(), false);
    for (const uint32_t material : scene.materials_of) {
        used[material] = true;
    }
    for (size_t i = 0; i < used.size(); ++i) {
        if (used[i] && maybeSpecular(scene, scene.materials[i])) {
            return true;
        }
    }
    return false;
}

vec3 emissionAt(const Scene& scene, uint32_t triangle, const vec3& barycentric) {
    const Material& material = scene.materials[scene.materials_of[triangle]];
    vec3 emission = material.params.emission;
    if (emission == vec3(0.0f)) {
        return emission;
    }
    const TextureUse& texture = material.textures[shared::TEXTURE_EMISSION];
    if (texture.used()) {
        emission *= vec3(texelAt(scene, triangle, barycentric, texture));
    }
    if (material.unlit) {
        emission *= vec3(vertexColorAt(scene, triangle, barycentric));
    }
    return emission;
}

float coverageAt(const Scene& scene, uint32_t triangle, const vec3& barycentric) {
    constexpr float kUnseen = 1.0f / 512.0f;  // half a step of 8 bits
    const Material& material = scene.materials[scene.materials_of[triangle]];
    if (!material.lightPasses()) {
        return 1.0f;
    }
    float alpha = material.alpha;
    if (material.alpha_texture.used()) {
        alpha *= texelAt(scene, triangle, barycentric, material.alpha_texture).w;
    }
    alpha *= vertexColorAt(scene, triangle, barycentric).w;
    if (material.masked()) {
        return alpha < material.alpha_cutoff ? 0.0f : 1.0f;
    }
    return alpha < kUnseen ? 0.0f : alpha > 1.0f - kUnseen ? 1.0f : alpha;
}

vec3 meanEmission(const Scene& scene, uint32_t triangle) {
    const Material& material = scene.materials[scene.materials_of[triangle]];
    const TextureUse& texture = material.textures[shared::TEXTURE_EMISSION];
    if (!material.emits() || !texture.used()) {
        // The middle's vertex colour is the mean.
        return emissionAt(scene, triangle, vec3(1.0f / 3.0f));
    }
    // Of n^2 parts of equal area, each by its middle.
    const int n = emissionDivisions(scene, triangle, texture);
    dvec3 sum(0.0);
    const auto add = [&](float u, float v) {
        const vec2 uv = vec2(u, v) / static_cast<float>(n);
        sum += dvec3(emissionAt(scene, triangle, vec3(1.0f - uv.x - uv.y, uv)));
    };
    for (int j = 0; j < n; ++j) {
        for (int i = 0; i + j < n; ++i) {
            const vec2 corner(i, j);
            add(corner.x + 1.0f / 3.0f, corner.y + 1.0f / 3.0f);
            if (i + j + 1 < n) {
                add(corner.x + 2.0f / 3.0f, corner.y + 2.0f / 3.0f);
            }
        }
    }
    return vec3(sum / (static_cast<double>(n) * n));
}

}  // namespace sheen
