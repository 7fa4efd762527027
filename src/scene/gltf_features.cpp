// What a file uses of glTF, and what becomes of it, in the words of docs/gltf.md.
#include <algorithm>

#include "scene/gltf_parts.h"

namespace sheen::gltf {
namespace {

constexpr const char* kRight = "right";
constexpr const char* kIgnored = "ignored";
constexpr const char* kUnseen = "ignored: it changes nothing that is seen";

// Those that a file may require; others are ignored where they are optional.
const std::map<std::string, const char*> kExtensions = {
    {"EXT_lights_image_based", "right: by its sharpest images; --environment replaces it"},
    {"EXT_mesh_gpu_instancing", kRight},
    {"EXT_meshopt_compression", kRight},
    {"EXT_texture_avif", kIgnored},
    {"EXT_texture_webp", kRight},
    {"KHR_animation_pointer", "approximated: of nodes, lights and cameras alone"},
    {"KHR_draco_mesh_compression", kRight},
    {"KHR_lights_punctual", kRight},
    {"KHR_materials_anisotropy", "approximated: a round highlight as wide on average"},
    {"KHR_materials_clearcoat",
     "approximated: in what rays see of it the coat scatters as a diffuse surface"},
    {"KHR_materials_diffuse_transmission", kIgnored},
    {"KHR_materials_dispersion", kIgnored},
    {"KHR_materials_emissive_strength", kRight},
    {"KHR_materials_ior", kRight},
    {"KHR_materials_iridescence", "approximated: by the angle at which the surface is seen"},
    {"KHR_materials_pbrSpecularGlossiness",
     "approximated: a dielectric with that specular colour, which takes from the diffuse light by "
     "its albedo"},
    {"KHR_materials_sheen", "approximated: as diffuse light of the same albedo"},
    {"KHR_materials_specular", kRight},
    {"KHR_materials_transmission",
     "approximated: cameras see through it, blurred; other light passes straight"},
    {"KHR_materials_unlit", "approximated: its colour is emission, which lights the scene"},
    {"KHR_materials_variants", kRight},
    {"KHR_materials_volume",
     "approximated: absorbs light, and bends cameras' rays; other light passes straight"},
    {"KHR_mesh_quantization", kRight},
    {"KHR_meshopt_compression", kRight},
    {"KHR_texture_basisu", kIgnored},
    {"KHR_texture_transform", kRight},
    {"KHR_xmp", kUnseen},
    {"KHR_xmp_json_ld", kUnseen},
    {"MOZ_lightmap", "right: by sheen render, in place of light of its own; ignored by all else"},
    {"MSFT_texture_dds", kIgnored},
};

const char* treatmentOf(const std::string& extension) {
    const auto known = kExtensions.find(extension);
    return known != kExtensions.end() ? known->second : kIgnored;
}

// Whether `of` holds for one of a list.
template <class T, class F>
bool any(const std::vector<T>& list, const F& of) {
    return std::any_of(list.begin(), list.end(), of);
}

}  // namespace

bool isUnderstood(const std::string& extension) { return kExtensions.count(extension) > 0; }

void noteIgnoredParts(File& file) {
    for (const std::string& name : file.model.extensionsUsed) {
        if (treatmentOf(name) == kIgnored) {
            file.notes.add(fmt::format("extension {} is not supported and ignored", oneLine(name)));
        }
    }
}

void listFeatures(const File& file, Scene& scene) {
    const tinygltf::Model& model = file.model;
    for (const std::string& name : model.extensionsUsed) {
        const bool variants = name == "KHR_materials_variants";
        scene.features.push_back(
            {oneLine(name), variants ? fmt::format("right: by --variant, one of {}", file.variants)
                                     : treatmentOf(name)});
    }
    const auto add = [&](bool used, const char* name, const char* treatment) {
        if (used) {
            scene.features.push_back({name, treatment});
        }
    };
    const auto material = [&](const auto& of) { return any(model.materials, of); };
    const auto primitive = [&](const auto& of) {
        return any(model.meshes,
                   [&](const tinygltf::Mesh& mesh) { return any(mesh.primitives, of); });
    };
    using Material = tinygltf::Material;
    using Primitive = tinygltf::Primitive;
    add(material([](const Material& m) {
            return m.pbrMetallicRoughness.metallicRoughnessTexture.index != -1;
        }),
        "metallic-roughness textures", kRight);
    add(material([](const Material& m) { return m.emissiveTexture.index != -1; }),
        "emissive textures", kRight);
    add(material([](const Material& m) { return m.normalTexture.index != -1; }), "normal textures",
        "approximated: indirect light of a bump is told by the smooth surface's");
    add(material([](const Material& m) { return m.occlusionTexture.index != -1; }),
        "occlusion textures", "ignored: the light they stand for is computed");
    add(material([](const Material& m) { return m.alphaMode == "MASK"; }), "alphaMode MASK",
        kRight);
    add(material([](const Material& m) { return m.alphaMode == "BLEND"; }), "alphaMode BLEND",
        "right but for records that are rasterised");
    add(primitive([](const Primitive& p) { return p.attributes.count("COLOR_0") > 0; }),
        "vertex colours", kRight);
    add(primitive([](const Primitive& p) { return !p.targets.empty(); }), "morph targets",
        "right: by the weights that are stored or move");
    add(primitive([](const Primitive& p) { return p.mode >= 0 && p.mode < 4; }), "points and lines",
        kIgnored);
    add(any(model.cameras, [](const tinygltf::Camera& c) { return c.type == "orthographic"; }),
        "orthographic cameras", "approximated: seen from afar");
    add(!model.skins.empty(), "skins", "right: where their joints stand");
    add(file.animated(), "animations", "right: by sheen animate; shown at rest by all else");
}

}  // namespace sheen::gltf
