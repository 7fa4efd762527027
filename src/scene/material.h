// What surfaces are made of: factors, and textures that vary them.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/math.h"
#include "scene/layers.h"
#include "scene/shared.h"
#include "scene/texture.h"

namespace sheen {

using shared::Brdf;
using shared::MaterialParams;

/// A lobe narrower than this alpha is specular: what it makes of lights is a caustic where it falls
/// on surfaces that are not.
constexpr float kSpecularAlpha = 0.15f;

/// Whether the specular lobe of a surface, if it has one, is specular in that sense.
inline bool isSpecular(const Brdf& brdf) {
    return brdf.alpha < kSpecularAlpha && (brdf.f90 > 0.0f || brdf.f0 != vec3(0.0f));
}

/// Of a texture that is looked up by Scene::lightmap_uvs.
constexpr int kLightmapUvs = 2;

/// One of a material's textures.
struct TextureUse {
    int texture = -1;  ///< index into Scene::textures; -1: none, white
    int uv_set = 0;    ///< which coordinates of the vertices: 0, 1 or kLightmapUvs
    shared::TextureTransform transform{.row_u = {1, 0}, .row_v = {0, 1}, .offset = {0, 0}};

    bool used() const { return texture >= 0; }
    bool operator==(const TextureUse& other) const {
        return texture == other.texture && uv_set == other.uv_set &&
               transform.row_u == other.transform.row_u &&
               transform.row_v == other.transform.row_v &&
               transform.offset == other.transform.offset;
    }
};

/// Baked light (MOZ_lightmap).
struct LightmapUse {
    TextureUse texture = {};  ///< irradiance, of which 1 stands for `intensity`
    float intensity = 1.0f;   ///< lux
    int file_set = 0;         ///< which TEXCOORD of the file Scene::lightmap_uvs are
    bool with_lamps = true;   ///< what lamps send is in it, and not the surroundings' light alone
};

struct Material {
    std::string name;       ///< one line
    MaterialParams params;  ///< factors, which the textures multiply
    std::array<TextureUse, shared::TEXTURE_USES> textures;  ///< by what they are for
    TextureUse normal_texture = {};
    float normal_scale = 1.0f;
    Layers layers = {};                      ///< factors, which these textures multiply
    TextureUse coat_texture = {};            ///< red
    TextureUse coat_roughness_texture = {};  ///< green
    TextureUse coat_normal_texture = {};
    float coat_normal_scale = 1.0f;
    TextureUse fibre_color_texture = {};
    TextureUse fibre_roughness_texture = {};  ///< alpha
    /// Shows its colour whatever the light: that is its emission, and it scatters nothing.
    bool unlit = false;
    LightmapUse lightmap = {};  ///< none unless Scene::lightmapped

    /// Its back is not seen by cameras; it hides and scatters light like its front.
    bool single_sided = false;
    float alpha = 1.0f;  ///< factor, which texture and vertices multiply
    /// What has less alpha is not there; 0: all of it is.
    float alpha_cutoff = 0.0f;
    /// What has less alpha than 1 lets the rest of the light pass.
    bool blended = false;
    TextureUse alpha_texture = {};
    /// Of a body of glass: by which light that travels in it falls, exp(-absorption * distance).
    vec3 absorption{0.0f};
    /// Of a body of glass its index of refraction, at least 1; 0: a sheet without body.
    float ior = 0.0f;

    bool textured() const {
        for (const TextureUse& use : textures) {
            if (use.used()) {
                return true;
            }
        }
        return normal_texture.used() || coat_texture.used() || coat_roughness_texture.used() ||
               coat_normal_texture.used() || fibre_color_texture.used() ||
               fibre_roughness_texture.used();
    }
    /// By whose coordinates tangents are: of the surface's normal map, else of its coat's.
    const TextureUse& tangentTexture() const {
        return normal_texture.used() ? normal_texture : coat_normal_texture;
    }
    /// Whether some point of it may be missing.
    bool masked() const { return alpha_cutoff > 0.0f; }
    /// Whether light may pass some point of it.
    bool lightPasses() const { return masked() || blended; }
    /// Whether it is glass, at some point.
    bool transmits() const {
        return params.transmission > 0.0f &&
               (params.metallic < 1.0f || textures[shared::TEXTURE_METALLIC_ROUGHNESS].used());
    }
    /// Whether it bounds a body of glass.
    bool bounds() const { return ior > 0.0f && transmits(); }
    /// Whether what passes it changes its direction there.
    bool refracts() const { return ior > 1.0f && transmits(); }
    /// Whether what passes some point of it is spread by its roughness.
    bool blurs() const { return transmits() && params.roughness > shared::MIN_ROUGHNESS; }
    /// Whether some point of it does.
    bool emits() const { return params.emission != vec3(0.0f); }
};

}  // namespace sheen
