// Materials: factors, and which textures vary them.
#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <utility>

#include "scene/gltf_parts.h"

namespace sheen::gltf {
namespace {

// The material that glTF has in mind where a file has none.
const MaterialParams kStandard = {.base_color = vec3(1.0f),
                                  .metallic = 1.0f,
                                  .specular_color = vec3(1.0f),
                                  .specular = 1.0f,
                                  .emission = vec3(0.0f),
                                  .roughness = 1.0f,
                                  .film = vec3(0.0f),
                                  .transmission = 0.0f};

float clampedFactor(File& file, double value, double upper, const std::string& where,
                    const char* what) {
    const float factor = finiteFloat(file, value, where, what);
    if (value < 0.0 || value > upper) {
        file.notes.add(fmt::format("{}: {} {} is out of range and clamped", where, what, value));
    }
    return std::clamp(factor, 0.0f, static_cast<float>(upper));
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

// Up to four numbers; those of `fallback` where the member is absent.
vec4 colorMember(File& file, const tinygltf::Value& extension, const char* key, int count,
                 double upper, const vec4& fallback, const std::string& where) {
    if (!extension.Has(key)) {
        return fallback;
    }
    const tinygltf::Value& color = extension.Get(key);
    vec4 result = fallback;
    for (int c = 0; c < count; ++c) {
        if (static_cast<int>(color.ArrayLen()) != count || !color.Get(c).IsNumber()) {
            file.fail(where, "{} must hold {} numbers", key, count);
        }
        result[c] = clampedFactor(file, color.Get(c).GetNumberAsDouble(), upper, where, key);
    }
    return result;
}

// How a material is extended by an extension; null: not.
const tinygltf::Value* extensionOf(const tinygltf::Material& source, const char* name) {
    const auto found = source.extensions.find(name);
    return found == source.extensions.end() ? nullptr : &found->second;
}

constexpr float kUsualF0 = 0.04f;  // of a dielectric, which specular_color multiplies

constexpr double kUsualIor = 1.5;

// The index of refraction, where it is told; infinite where it is 0, as converters write that.
std::optional<double> indexOf(File& file, const tinygltf::Material& source,
                              const std::string& where) {
    const tinygltf::Value* extension = extensionOf(source, "KHR_materials_ior");
    if (extension == nullptr) {
        return std::nullopt;
    }
    const double ior =
        finiteFloat(file, numberMember(file, *extension, "ior", kUsualIor, where), where, "ior");
    if (ior != 0.0 && ior < 1.0) {
        file.notes.add(fmt::format("{}: ior {} is below 1 and counts as 1", where, ior));
    }
    return ior == 0.0 ? std::numeric_limits<double>::infinity() : std::max(ior, 1.0);
}

// What a surface of that index reflects at normal incidence.
double reflectedByIndex(double ior) {
    const double root = std::isinf(ior) ? 1.0 : (ior - 1.0) / (ior + 1.0);
    return root * root;
}

void readSpecular(File& file, const tinygltf::Value& extension, const std::string& where,
                  TextureLoader& loader, Material& material) {
    material.params.specular =
        clampedFactor(file, numberMember(file, extension, "specularFactor", 1.0, where), 1.0, where,
                      "specularFactor");
    material.params.specular_color *=
        vec3(colorMember(file, extension, "specularColorFactor", 3,
                         std::numeric_limits<float>::max(), vec4(1.0f), where));
    material.textures[shared::TEXTURE_SPECULAR] =
        loader.use(memberTexture(file, extension, "specularTexture", where), false, where);
    material.textures[shared::TEXTURE_SPECULAR_COLOR] =
        loader.use(memberTexture(file, extension, "specularColorTexture", where), true, where);
}

void readMetallicRoughness(File& file, const tinygltf::Material& source, const std::string& where,
                           const std::optional<double>& ior, TextureLoader& loader,
                           Material& material) {
    const tinygltf::PbrMetallicRoughness& pbr = source.pbrMetallicRoughness;
    if (pbr.baseColorFactor.size() != 4) {
        file.fail(where, "baseColorFactor must hold four numbers and emissiveFactor three");
    }
    MaterialParams& params = material.params;
    params.metallic = clampedFactor(file, pbr.metallicFactor, 1.0, where, "metallicFactor");
    params.roughness = clampedFactor(file, pbr.roughnessFactor, 1.0, where, "roughnessFactor");
    const auto base = [&](size_t c) {
        return clampedFactor(file, pbr.baseColorFactor[c], 1.0, where, "baseColorFactor");
    };
    params.base_color = vec3(base(0), base(1), base(2));
    material.alpha = base(3);
    material.textures[shared::TEXTURE_BASE_COLOR] =
        loader.use(infoOf(pbr.baseColorTexture), true, where);
    material.textures[shared::TEXTURE_METALLIC_ROUGHNESS] =
        loader.use(infoOf(pbr.metallicRoughnessTexture), false, where);
    if (ior) {
        params.specular_color *= static_cast<float>(reflectedByIndex(*ior)) / kUsualF0;
    }
    if (const tinygltf::Value* specular = extensionOf(source, "KHR_materials_specular")) {
        readSpecular(file, *specular, where, loader, material);
    }
}

// A dielectric of that specular colour, whatever the colour: that is what the model amounts to.
void readSpecularGlossiness(File& file, const tinygltf::Value& extension, const std::string& where,
                            TextureLoader& loader, Material& material) {
    MaterialParams& params = material.params;
    const vec4 diffuse = colorMember(file, extension, "diffuseFactor", 4, 1.0, vec4(1.0f), where);
    const vec3 specular(colorMember(file, extension, "specularFactor", 3, 1.0, vec4(1.0f), where));
    const float glossiness =
        clampedFactor(file, numberMember(file, extension, "glossinessFactor", 1.0, where), 1.0,
                      where, "glossinessFactor");
    params.base_color = vec3(diffuse);
    params.metallic = 0.0f;
    params.specular_color = specular / kUsualF0;
    params.roughness = 1.0f - glossiness;
    material.alpha = diffuse.w;
    material.textures[shared::TEXTURE_BASE_COLOR] =
        loader.use(memberTexture(file, extension, "diffuseTexture", where), true, where);
    const TextureUse use =
        loader.use(memberTexture(file, extension, "specularGlossinessTexture", where), true, where);
    material.textures[shared::TEXTURE_SPECULAR_COLOR] = use;
    if (use.used()) {
        material.textures[shared::TEXTURE_METALLIC_ROUGHNESS] = loader.roughnessOf(use, glossiness);
        params.roughness = 1.0f;
    }
}

void readEmission(File& file, const tinygltf::Material& source, const std::string& where,
                  TextureLoader& loader, Material& material) {
    if (source.emissiveFactor.size() != 3) {
        file.fail(where, "baseColorFactor must hold four numbers and emissiveFactor three");
    }
    const tinygltf::Value* extension = extensionOf(source, "KHR_materials_emissive_strength");
    const double strength =
        extension == nullptr ? 1.0 : numberMember(file, *extension, "emissiveStrength", 1.0, where);
    for (int c = 0; c < 3; ++c) {
        material.params.emission[c] =
            clampedFactor(file, source.emissiveFactor[static_cast<size_t>(c)] * strength,
                          std::numeric_limits<float>::max(), where, "emission");
    }
    TextureUse& use = material.textures[shared::TEXTURE_EMISSION];
    use = loader.use(infoOf(source.emissiveTexture), true, where);
    if (source.emissiveTexture.index != -1 && !use.used()) {
        // The factor without its texture, mostly black, would make all of the surface shine.
        material.params.emission = vec3(0.0f);
    }
}

// What is left of it, and on which sides.
void readCoverage(File& file, const tinygltf::Material& source, const std::string& where,
                  Material& material) {
    material.single_sided = !source.doubleSided;
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

// Light passes it as it does what is blended: straight.
void readTransmission(File& file, const tinygltf::Value& extension, const std::string& where,
                      TextureLoader& loader, Material& material) {
    material.params.transmission =
        clampedFactor(file, numberMember(file, extension, "transmissionFactor", 0.0, where), 1.0,
                      where, "transmissionFactor");
    material.textures[shared::TEXTURE_TRANSMISSION] =
        loader.use(memberTexture(file, extension, "transmissionTexture", where), false, where);
    if (material.transmits()) {
        material.alpha = material.lightPasses() ? material.alpha : 1.0f;
        material.blended = true;
    }
}

// Bodies of glass absorb over the distance that light travels in them; a thickness of 0 is a sheet.
// How thick it says that they are has no say: rays know.
void readVolume(File& file, const tinygltf::Value& extension, const std::string& where, double ior,
                Material& material) {
    constexpr double kFarthest = std::numeric_limits<float>::max();
    const auto factor = [&](const char* key, double fallback) {
        return clampedFactor(file, numberMember(file, extension, key, fallback, where), kFarthest,
                             where, key);
    };
    const vec3 color(colorMember(file, extension, "attenuationColor", 3, 1.0, vec4(1.0f), where));
    const float distance = factor("attenuationDistance", 0.0);  // without, none absorbs
    if (!(factor("thicknessFactor", 0.0) > 0.0f && material.transmits())) {
        return;
    }
    material.ior = std::isinf(ior) ? 1.0f : static_cast<float>(ior);  // nothing passes it
    if (distance > 0.0f) {
        constexpr float kDarkest = 1e-6f;  // a channel that nothing is left of
        constexpr float kMost =
            1e9f;  // per unit of length: nothing is left, and no product overflows
        material.absorption =
            glm::min(-glm::log(glm::max(color, vec3(kDarkest))) / distance, vec3(kMost));
    }
}

void readClearcoat(File& file, const tinygltf::Value& extension, const std::string& where,
                   TextureLoader& loader, Material& material) {
    const auto factor = [&](const char* key) {
        return clampedFactor(file, numberMember(file, extension, key, 0.0, where), 1.0, where, key);
    };
    material.layers.coat = factor("clearcoatFactor");
    material.layers.coat_roughness = factor("clearcoatRoughnessFactor");
    material.coat_texture =
        loader.use(memberTexture(file, extension, "clearcoatTexture", where), false, where);
    material.coat_roughness_texture = loader.use(
        memberTexture(file, extension, "clearcoatRoughnessTexture", where), false, where);
    if (extension.Has("clearcoatNormalTexture")) {
        const tinygltf::Value& normal = extension.Get("clearcoatNormalTexture");
        material.coat_normal_texture = loader.use(textureInfo(file, normal, where), false, where);
        material.coat_normal_scale =
            finiteFloat(file, numberMember(file, normal, "scale", 1.0, where), where, "scale");
    }
}

void readSheen(File& file, const tinygltf::Value& extension, const std::string& where,
               TextureLoader& loader, Material& material) {
    material.layers.fibre_color =
        vec3(colorMember(file, extension, "sheenColorFactor", 3, 1.0, vec4(0.0f), where));
    material.layers.fibre_roughness =
        clampedFactor(file, numberMember(file, extension, "sheenRoughnessFactor", 0.0, where), 1.0,
                      where, "sheenRoughnessFactor");
    material.fibre_color_texture =
        loader.use(memberTexture(file, extension, "sheenColorTexture", where), true, where);
    material.fibre_roughness_texture =
        loader.use(memberTexture(file, extension, "sheenRoughnessTexture", where), false, where);
}

// A film as thick as its upper bound, and by a texture thinner.
void readIridescence(File& file, const tinygltf::Value& extension, const std::string& where,
                     TextureLoader& loader, Material& material) {
    constexpr double kMostNumber = std::numeric_limits<float>::max();
    const auto factor = [&](const char* key, double fallback, double upper) {
        return clampedFactor(file, numberMember(file, extension, key, fallback, where), upper,
                             where, key);
    };
    vec3& film = material.params.film;
    film.x = factor("iridescenceFactor", 0.0, 1.0);
    film.y = factor("iridescenceIor", 1.3, kMostNumber);
    const float thinnest = factor("iridescenceThicknessMinimum", 100.0, kMostNumber);
    film.z = factor("iridescenceThicknessMaximum", 400.0, kMostNumber);
    if (film.y < 1.0f) {
        file.notes.add(
            fmt::format("{}: iridescenceIor {} is below 1 and counts as 1", where, film.y));
        film.y = 1.0f;
    }
    material.textures[shared::TEXTURE_FILM] =
        loader.use(memberTexture(file, extension, "iridescenceTexture", where), false, where);
    const TextureUse thickness = loader.use(
        memberTexture(file, extension, "iridescenceThicknessTexture", where), false, where);
    const float thickest = std::max(thinnest, film.z);
    if (thickness.used() && thickest > 0.0f) {
        material.textures[shared::TEXTURE_FILM_THICKNESS] =
            loader.withGreenBetween(thickness, thinnest / thickest, film.z / thickest);
        film.z = thickest;
    }
}

// A round lobe as wide as the elliptical one is on average: widths are alpha and, along the
// direction, mix(alpha, 1, strength^2).
void readAnisotropy(File& file, const tinygltf::Value& extension, const std::string& where,
                    Material& material) {
    const float strength =
        clampedFactor(file, numberMember(file, extension, "anisotropyStrength", 0.0, where), 1.0,
                      where, "anisotropyStrength");
    float& roughness = material.params.roughness;
    const float alpha = roughness * roughness;
    const float along = glm::mix(alpha, 1.0f, strength * strength);
    roughness = std::sqrt(std::sqrt(alpha * along));
}

// Its colour, whatever the light, is what it emits.
void makeUnlit(Material& material) {
    material.unlit = true;
    material.params = {.base_color = vec3(0.0f),
                       .metallic = 0.0f,
                       .specular_color = vec3(1.0f),
                       .specular = 0.0f,
                       .emission = material.params.base_color,
                       .roughness = 1.0f,
                       .film = vec3(0.0f),
                       .transmission = 0.0f};
    const TextureUse color = material.textures[shared::TEXTURE_BASE_COLOR];
    material.textures = {};
    material.normal_texture = {};
    material.coat_normal_texture = {};
    material.layers = {};
    material.textures[shared::TEXTURE_EMISSION] = color;
}

// `direct`, in its extras, is Sheen's own: false where what lights and lamps send is not in it.
void readLightmap(File& file, const tinygltf::Value& extension, const std::string& where,
                  TextureLoader& loader, Material& material) {
    LightmapUse& lightmap = material.lightmap;
    lightmap.texture = loader.useLightmap(textureInfo(file, extension, where), where);
    lightmap.file_set = std::max(std::exchange(lightmap.texture.uv_set, kLightmapUvs), 0);
    lightmap.intensity = clampedFactor(file, numberMember(file, extension, "intensity", 1.0, where),
                                       std::numeric_limits<float>::max(), where, "intensity");
    if (extension.Has("extras") && extension.Get("extras").IsObject()) {
        const tinygltf::Value& direct = extension.Get("extras").Get("direct");
        lightmap.with_lamps = !direct.IsBool() || direct.Get<bool>();
    }
}

Material loadMaterial(File& file, size_t index, bool lightmaps, TextureLoader& loader) {
    const tinygltf::Material& source = file.model.materials[index];
    const std::string where = label("material", index, source.name);
    Material material;
    material.name = source.name.empty() ? fmt::format("material {}", index) : oneLine(source.name);
    material.params = kStandard;
    const std::optional<double> ior = indexOf(file, source, where);
    if (const auto* extension = extensionOf(source, "KHR_materials_pbrSpecularGlossiness")) {
        readSpecularGlossiness(file, *extension, where, loader, material);
    } else {
        readMetallicRoughness(file, source, where, ior, loader, material);
    }
    readEmission(file, source, where, loader, material);
    material.normal_texture = loader.use(infoOf(source.normalTexture), false, where);
    material.normal_scale = finiteFloat(file, source.normalTexture.scale, where, "scale");
    readCoverage(file, source, where, material);
    const bool unlit = source.extensions.count("KHR_materials_unlit") > 0;
    if (const auto* extension = extensionOf(source, "KHR_materials_transmission");
        extension != nullptr && !unlit) {
        readTransmission(file, *extension, where, loader, material);
    }
    if (const auto* extension = extensionOf(source, "KHR_materials_volume")) {
        readVolume(file, *extension, where, ior.value_or(kUsualIor), material);
    }
    if (const auto* extension = extensionOf(source, "KHR_materials_clearcoat")) {
        readClearcoat(file, *extension, where, loader, material);
    }
    if (const auto* extension = extensionOf(source, "KHR_materials_sheen")) {
        readSheen(file, *extension, where, loader, material);
    }
    if (const auto* extension = extensionOf(source, "KHR_materials_iridescence")) {
        readIridescence(file, *extension, where, loader, material);
    }
    if (const auto* extension = extensionOf(source, "KHR_materials_anisotropy")) {
        readAnisotropy(file, *extension, where, material);
    }
    if (const auto* extension = extensionOf(source, "MOZ_lightmap");
        extension != nullptr && lightmaps && !unlit) {
        readLightmap(file, *extension, where, loader, material);
    }
    if (unlit) {
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

std::vector<std::string> variantNames(const File& file) {
    std::vector<std::string> names;
    const auto found = file.model.extensions.find("KHR_materials_variants");
    if (found == file.model.extensions.end() || !found->second.Has("variants")) {
        return names;
    }
    const tinygltf::Value& variants = found->second.Get("variants");
    for (size_t i = 0; i < variants.ArrayLen(); ++i) {
        const tinygltf::Value& variant = variants.Get(i);
        const bool named = variant.Has("name") && variant.Get("name").IsString();
        names.push_back(named ? variant.Get("name").Get<std::string>() : std::string());
    }
    return names;
}

}  // namespace

void chooseVariant(File& file, const std::string& name) {
    const std::vector<std::string> names = variantNames(file);
    for (const std::string& known : names) {
        file.variants += (file.variants.empty() ? "" : ", ") + oneLine(known);
    }
    if (name.empty()) {
        return;
    }
    const auto chosen = std::find(names.begin(), names.end(), name);
    if (chosen == names.end()) {
        throwUsage("--variant {}: no such variant; the scene has {}", oneLine(name),
                   names.empty() ? "none" : file.variants);
    }
    file.variant = static_cast<int>(chosen - names.begin());
}

int materialOf(const File& file, const tinygltf::Primitive& primitive, const std::string& where) {
    const auto found = primitive.extensions.find("KHR_materials_variants");
    if (file.variant < 0 || found == primitive.extensions.end() || !found->second.Has("mappings")) {
        return primitive.material;
    }
    const tinygltf::Value& mappings = found->second.Get("mappings");
    for (size_t i = 0; i < mappings.ArrayLen(); ++i) {
        const tinygltf::Value& mapping = mappings.Get(i);
        if (!mapping.Has("variants")) {
            continue;
        }
        const tinygltf::Value& variants = mapping.Get("variants");
        for (size_t v = 0; v < variants.ArrayLen(); ++v) {
            if (variants.Get(v).IsNumber() && variants.Get(v).GetNumberAsInt() == file.variant) {
                return integerMember(file, mapping, "material", -1, where);
            }
        }
    }
    return primitive.material;
}

void dropIdleBlending(Scene& scene) {
    const bool opaque_vertices = std::all_of(scene.colors.begin(), scene.colors.end(),
                                             [](const vec4& color) { return color.w == 1.0f; });
    for (Material& material : scene.materials) {
        const bool opaque_texture =
            !material.alpha_texture.used() ||
            opaqueTexels(scene.images[static_cast<size_t>(
                scene.textures[static_cast<size_t>(material.alpha_texture.texture)].image)]);
        if (material.blended && !material.transmits() && material.alpha == 1.0f &&
            opaque_vertices && opaque_texture) {
            material.blended = false;
            material.alpha_texture = {};
        }
    }
}

void loadMaterials(File& file, bool lightmaps, Scene& scene) {
    TextureLoader loader(file, scene);
    for (size_t i = 0; i < file.model.materials.size(); ++i) {
        scene.materials.push_back(loadMaterial(file, i, lightmaps, loader));
    }
    Material standard;
    standard.name = "default";
    standard.params = kStandard;
    scene.materials.push_back(standard);
}

void settleLightmaps(File& file, bool wanted, Scene& scene) {
    if (!file.uses("MOZ_lightmap")) {
        return;
    }
    if (!wanted) {
        file.notes.add(
            "the file's lightmaps are ignored: sheen render --method lightmap shows them");
        return;
    }
    const Material* lacking = nullptr;
    scene.lamps_baked = false;
    for (const uint32_t index : scene.materials_of) {
        const Material& material = scene.materials[index];
        if (!material.unlit && !material.lightmap.texture.used()) {
            lacking = &material;
        }
        scene.lamps_baked = scene.lamps_baked || (!material.unlit && material.lightmap.with_lamps);
    }
    scene.lightmapped = lacking == nullptr && !scene.materials_of.empty();
    if (lacking != nullptr) {
        file.notes.add(fmt::format(
            "the file's lightmaps are ignored: {} has none, or a mesh of it no coordinates for it; "
            "bake all of the scene",
            lacking->name));
    }
    if (!scene.lightmapped) {
        scene.lamps_baked = false;
        scene.lightmap_uvs.clear();
        for (Material& material : scene.materials) {
            material.lightmap = {};
        }
    }
}

}  // namespace sheen::gltf
