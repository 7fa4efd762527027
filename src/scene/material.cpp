// The material at a point of a surface.
#include "scene/material.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "scene/brdf_albedo.h"
#include "scene/scene.h"

namespace sheen {
namespace {

// Twice its area.
float area2Of(const Scene& scene, uint32_t triangle) {
    const uvec3& t = scene.triangles[triangle];
    const vec3& p0 = scene.positions[t.x];
    return glm::length(glm::cross(scene.positions[t.y] - p0, scene.positions[t.z] - p0));
}

// Where each of a material's textures is looked up.
vec2 uvOf(const Scene& scene, uint32_t triangle, const vec3& barycentric, const TextureUse& use) {
    const uvec3& t = scene.triangles[triangle];
    const std::vector<vec2>& uvs = use.uv_set == kLightmapUvs ? scene.lightmap_uvs
                                   : use.uv_set == 1          ? scene.second_uvs
                                                              : scene.uvs;
    if (uvs.empty()) {
        return use.transform.offset;
    }
    return shared::transformedUv(
        use.transform,
        barycentric.x * uvs[t.x] + barycentric.y * uvs[t.y] + barycentric.z * uvs[t.z]);
}

// `footprint_over_area2`: the area that the look stands for, of twice the triangle's; 0: a point.
vec4 texelAt(const Scene& scene, uint32_t triangle, const vec3& barycentric, const TextureUse& use,
             float footprint_over_area2 = 0.0f) {
    const Texture& texture = scene.textures[static_cast<size_t>(use.texture)];
    const TextureImage& image = scene.images[static_cast<size_t>(texture.image)];
    float level = 0.0f;
    if (footprint_over_area2 > 0.0f) {
        const vec2 origin = uvOf(scene, triangle, vec3(1, 0, 0), use);
        level = shared::textureLevel(
            footprint_over_area2, uvOf(scene, triangle, vec3(0, 1, 0), use) - origin,
            uvOf(scene, triangle, vec3(0, 0, 1), use) - origin, {image.width, image.height});
    }
    return sampled(image, texture, uvOf(scene, triangle, barycentric, use), level);
}

// What a look stands for, of twice the triangle's area: 0 unless its material has textures.
float footprintOverArea2(const Scene& scene, uint32_t triangle, float footprint) {
    return footprint > 0.0f && scene.materials[scene.materials_of[triangle]].textured()
               ? footprint / area2Of(scene, triangle)
               : 0.0f;
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

ShadingNormals normalsAt(const Scene& scene, uint32_t triangle, const vec3& barycentric,
                         const vec3& n_g, const vec3& wo, float footprint) {
    const uvec3& t = scene.triangles[triangle];
    const auto interpolated = [&](const auto& values) {
        return barycentric.x * values[t.x] + barycentric.y * values[t.y] +
               barycentric.z * values[t.z];
    };
    const vec3 n = shared::interpolatedNormal(interpolated(scene.normals), n_g);
    ShadingNormals normals;
    normals.smooth = normals.mapped = normals.coat = shared::shadingNormal(n, n_g, wo);
    const Material& material = scene.materials[scene.materials_of[triangle]];
    if (!material.tangentTexture().used() || scene.tangents.empty()) {
        return normals;
    }
    const auto map = [&](const TextureUse& texture, float scale, vec3& normal) {
        if (texture.used()) {
            normal = shared::mappedNormal(n, interpolated(scene.tangents),
                                          texelAt(scene, triangle, barycentric, texture,
                                                  footprintOverArea2(scene, triangle, footprint)),
                                          scale, n_g, wo);
        }
    };
    map(material.normal_texture, material.normal_scale, normals.mapped);
    map(material.coat_normal_texture, material.coat_normal_scale, normals.coat);
    return normals;
}

MaterialParams materialAt(const Scene& scene, uint32_t triangle, const vec3& barycentric,
                          float footprint) {
    const Material& material = scene.materials[scene.materials_of[triangle]];
    MaterialParams params = material.params;
    const float over_area2 = footprintOverArea2(scene, triangle, footprint);
    for (int use = 0; use < shared::TEXTURE_USES; ++use) {
        const TextureUse& texture = material.textures[static_cast<size_t>(use)];
        if (texture.used()) {
            params = shared::withTexel(params, use,
                                       texelAt(scene, triangle, barycentric, texture, over_area2));
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
    const Texture& looked_up = scene.textures[static_cast<size_t>(texture.texture)];
    const std::vector<vec4> texels =
        linearTexels(scene.images[static_cast<size_t>(looked_up.image)], looked_up.srgb);
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

Layers layersAt(const Scene& scene, uint32_t triangle, const vec3& barycentric, float footprint) {
    const Material& material = scene.materials[scene.materials_of[triangle]];
    Layers layers = material.layers;
    if (layers.none()) {
        return layers;
    }
    const float over_area2 = footprintOverArea2(scene, triangle, footprint);
    const auto texel = [&](const TextureUse& use) {
        return use.used() ? texelAt(scene, triangle, barycentric, use, over_area2) : vec4(1.0f);
    };
    layers.coat *= texel(material.coat_texture).x;
    layers.coat_roughness *= texel(material.coat_roughness_texture).y;
    layers.fibre_color *= vec3(texel(material.fibre_color_texture));
    layers.fibre_roughness *= texel(material.fibre_roughness_texture).w;
    return layers;
}

vec3 emissionAt(const Scene& scene, uint32_t triangle, const vec3& barycentric, float footprint) {
    const Material& material = scene.materials[scene.materials_of[triangle]];
    vec3 emission = material.params.emission;
    if (emission == vec3(0.0f)) {
        return emission;
    }
    const TextureUse& texture = material.textures[shared::TEXTURE_EMISSION];
    if (texture.used()) {
        emission *= vec3(texelAt(scene, triangle, barycentric, texture,
                                 footprintOverArea2(scene, triangle, footprint)));
    }
    if (material.unlit) {
        emission *= vec3(vertexColorAt(scene, triangle, barycentric));
    }
    return emission;
}

vec3 lightmapAt(const Scene& scene, uint32_t triangle, const vec3& barycentric) {
    const LightmapUse& lightmap = scene.materials[scene.materials_of[triangle]].lightmap;
    if (!lightmap.texture.used()) {  // of what has appeared since the scene was loaded
        return vec3(0.0f);
    }
    return lightmap.intensity * vec3(texelAt(scene, triangle, barycentric, lightmap.texture));
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

Crossing crossingAt(const Scene& scene, uint32_t triangle, const vec3& barycentric,
                    const vec3& along) {
    constexpr float kLeastChance = 1.0f / 128.0f;  // clear glass may emit, or have a coat
    constexpr float kBlack = 1e-12f;
    const float alpha = coverageAt(scene, triangle, barycentric);
    if (alpha == 0.0f || !scene.materials[scene.materials_of[triangle]].transmits()) {
        return {.meets = alpha, .chance = alpha, .passes = vec3(1.0f - alpha)};
    }
    const vec3 n_g = shared::faceViewer(geometricNormal(scene, static_cast<int>(triangle)), -along);
    const ShadingNormals normals = normalsAt(scene, triangle, barycentric, n_g, -along);
    const float NoV = glm::dot(normals.mapped, -along);
    // What it would scatter if it transmitted nothing.
    MaterialParams opaque = materialAt(scene, triangle, barycentric);
    const float transmission = std::exchange(opaque.transmission, 0.0f);
    const Brdf brdf = shared::makeBrdf(opaque, NoV, brdfAlbedo(NoV, opaque.roughness));
    const float under = shareUnderLayers(layersAt(scene, triangle, barycentric), NoV,
                                         glm::dot(normals.coat, -along));
    // A body is entered and left: each colours what passes by the root of its colour, so that both
    // do once.
    const vec3 tint = scene.materials[scene.materials_of[triangle]].bounds()
                          ? 1.0f / glm::sqrt(glm::max(opaque.base_color, vec3(kBlack)))
                          : vec3(1.0f);
    const vec3 passes = (1.0f - alpha) + alpha * transmission * under * tint * brdf.diffuse;
    return {.meets = alpha,
            .chance = std::clamp(1.0f - maxAbs(passes), kLeastChance, 1.0f),
            .passes = passes};
}

Brdf fromWithin(const Brdf& outside, float roughness, float cosine) {
    Brdf within = outside;
    within.f0 = specularAlbedo(cosine, roughness, outside.f0, outside.f90);
    within.f90 = maxAbs(within.f0);
    return within;
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
