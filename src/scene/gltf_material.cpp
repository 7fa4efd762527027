// Materials: factors, and which textures vary them.
#include <algorithm>

#include "scene/gltf_parts.h"

namespace sheen::gltf {
namespace {

float clampedFactor(File& file, double value, double upper, const std::string& where,
                    const char* what) {
    const float factor = finiteFloat(file, value, where, what);
    if (value < 0.0 || value > upper) {
        file.notes.add(fmt::format("{}: {} {} is out of range and clamped", where, what, value));
    }
    return std::clamp(factor, 0.0f, static_cast<float>(upper));
}

void readSpecular(File& file, const tinygltf::Value& extension, const std::string& where,
                  MaterialParams& params) {
    params.specular =
        clampedFactor(file, numberMember(file, extension, "specularFactor", 1.0, where), 1.0, where,
                      "specularFactor");
    if (extension.Has("specularColorFactor")) {
        const tinygltf::Value& color = extension.Get("specularColorFactor");
        if (color.ArrayLen() != 3) {
            file.fail(where, "specularColorFactor must hold three numbers");
        }
        for (int c = 0; c < 3; ++c) {
            if (!color.Get(c).IsNumber()) {
                file.fail(where, "specularColorFactor must hold three numbers");
            }
            params.specular_color[c] =
                clampedFactor(file, color.Get(c).GetNumberAsDouble(),
                              std::numeric_limits<float>::max(), where, "specularColorFactor");
        }
    }
}

// One of the textures of an extension.
TextureInfo memberTexture(const File& file, const tinygltf::Value& extension, const char* key,
                          const std::string& where) {
    return extension.Has(key) ? textureInfo(file, extension.Get(key), where) : TextureInfo{};
}

// Of a texture of the core specification.
template <class Source>
TextureInfo infoOf(const Source& source) {
    const auto found = source.extensions.find("KHR_texture_transform");
    return {.index = source.index,
            .uv_set = source.texCoord,
            .transform = found == source.extensions.end() ? tinygltf::Value() : found->second};
}

void loadTextures(const File& file, const tinygltf::Material& source, const std::string& where,
                  TextureLoader& loader, Material& material) {
    auto& textures = material.textures;
    const tinygltf::PbrMetallicRoughness& pbr = source.pbrMetallicRoughness;
    textures[shared::TEXTURE_BASE_COLOR] = loader.use(infoOf(pbr.baseColorTexture), true, where);
    textures[shared::TEXTURE_METALLIC_ROUGHNESS] =
        loader.use(infoOf(pbr.metallicRoughnessTexture), false, where);
    textures[shared::TEXTURE_EMISSION] = loader.use(infoOf(source.emissiveTexture), true, where);
    material.normal_texture = loader.use(infoOf(source.normalTexture), false, where);
    material.normal_scale = finiteFloat(file, source.normalTexture.scale, where, "scale");
    if (source.emissiveTexture.index != -1 && !textures[shared::TEXTURE_EMISSION].used()) {
        // The factor without its texture, mostly black, would make all of the surface shine.
        material.params.emission = vec3(0.0f);
    }
    const auto specular = source.extensions.find("KHR_materials_specular");
    if (specular != source.extensions.end()) {
        textures[shared::TEXTURE_SPECULAR] = loader.use(
            memberTexture(file, specular->second, "specularTexture", where), false, where);
        textures[shared::TEXTURE_SPECULAR_COLOR] = loader.use(
            memberTexture(file, specular->second, "specularColorTexture", where), true, where);
    }
}

// What is left of it, and on which sides.
void readCoverage(File& file, const tinygltf::Material& source, const std::string& where,
                  Material& material) {
    material.single_sided = !source.doubleSided;
    material.alpha = clampedFactor(file, source.pbrMetallicRoughness.baseColorFactor[3], 1.0, where,
                                   "baseColorFactor");
    if (source.alphaMode == "MASK") {
        material.alpha_cutoff = finiteFloat(file, source.alphaCutoff, where, "alphaCutoff");
    } else if (source.alphaMode == "BLEND") {
        material.blended = true;
    } else if (source.alphaMode != "OPAQUE") {
        file.notes.add(fmt::format("alphaMode {} is unknown: material shown opaque",
                                   oneLine(source.alphaMode)));
    }
    if (material.lightPasses()) {
        material.alpha_texture = material.textures[shared::TEXTURE_BASE_COLOR];
    }
}

// Its colour, whatever the light, is what it emits.
void makeUnlit(Material& material) {
    material.unlit = true;
    material.params = {.base_color = vec3(0.0f),
                       .metallic = 0.0f,
                       .specular_color = vec3(1.0f),
                       .specular = 0.0f,
                       .emission = material.params.base_color,
                       .roughness = 1.0f};
    const TextureUse color = material.textures[shared::TEXTURE_BASE_COLOR];
    material.textures = {};
    material.normal_texture = {};
    material.textures[shared::TEXTURE_EMISSION] = color;
}

Material loadMaterial(File& file, size_t index, TextureLoader& loader) {
    const tinygltf::Material& source = file.model.materials[index];
    const std::string where = label("material", index, source.name);
    const tinygltf::PbrMetallicRoughness& pbr = source.pbrMetallicRoughness;
    if (pbr.baseColorFactor.size() != 4 || source.emissiveFactor.size() != 3) {
        file.fail(where, "baseColorFactor must hold four numbers and emissiveFactor three");
    }
    Material material;
    material.name = source.name.empty() ? fmt::format("material {}", index) : oneLine(source.name);
    MaterialParams& params = material.params;
    params.metallic = clampedFactor(file, pbr.metallicFactor, 1.0, where, "metallicFactor");
    params.roughness = clampedFactor(file, pbr.roughnessFactor, 1.0, where, "roughnessFactor");
    params.specular = 1.0f;
    params.specular_color = vec3(1.0f);
    double strength = 1.0;
    for (const auto& [name, extension] : source.extensions) {
        if (name == "KHR_materials_specular") {
            readSpecular(file, extension, where, params);
        } else if (name == "KHR_materials_emissive_strength") {
            strength *= numberMember(file, extension, "emissiveStrength", 1.0, where);
        }
    }
    for (int c = 0; c < 3; ++c) {
        const auto i = static_cast<size_t>(c);
        params.base_color[c] =
            clampedFactor(file, pbr.baseColorFactor[i], 1.0, where, "baseColorFactor");
        params.emission[c] = clampedFactor(file, source.emissiveFactor[i] * strength,
                                           std::numeric_limits<float>::max(), where, "emission");
    }
    loadTextures(file, source, where, loader, material);
    readCoverage(file, source, where, material);
    if (source.extensions.count("KHR_materials_unlit") > 0) {
        makeUnlit(material);
    }
    return material;
}

bool opaqueTexels(const TextureImage& image) {
    for (size_t i = 3; i < image.bytes.size(); i += 4) {
        if (image.bytes[i] != 255) {
            return false;
        }
    }
    for (size_t i = 3; i < image.words.size(); i += 4) {
        if (image.words[i] != 65535) {
            return false;
        }
    }
    return true;
}

}  // namespace

void dropIdleBlending(Scene& scene) {
    const bool opaque_vertices = std::all_of(scene.colors.begin(), scene.colors.end(),
                                             [](const vec4& color) { return color.w == 1.0f; });
    for (Material& material : scene.materials) {
        const bool opaque_texture =
            !material.alpha_texture.used() ||
            opaqueTexels(scene.images[static_cast<size_t>(
                scene.textures[static_cast<size_t>(material.alpha_texture.texture)].image)]);
        if (material.blended && material.alpha == 1.0f && opaque_vertices && opaque_texture) {
            material.blended = false;
            material.alpha_texture = {};
        }
    }
}

void loadMaterials(File& file, Scene& scene) {
    TextureLoader loader(file, scene);
    for (size_t i = 0; i < file.model.materials.size(); ++i) {
        scene.materials.push_back(loadMaterial(file, i, loader));
    }
    Material standard;
    standard.name = "default";
    standard.params = {.base_color = vec3(1.0f),
                       .metallic = 1.0f,
                       .specular_color = vec3(1.0f),
                       .specular = 1.0f,
                       .emission = vec3(0.0f),
                       .roughness = 1.0f};
    scene.materials.push_back(standard);
}

}  // namespace sheen::gltf
