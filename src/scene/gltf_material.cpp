// Materials and their base-colour textures.
#include <algorithm>
#include <array>
#include <cmath>

#include "core/memory.h"
#include "image/decode.h"
#include "scene/gltf_parts.h"

namespace sheen::gltf {
namespace {

// An image of more texels is refused: as linear light, it takes 12 bytes a texel.
constexpr int64_t kMaxTexels = int64_t{1} << 27;
// What a byte of a file can hold at most: zlib packs 1032 bytes of 8 texels each into one, and
// JPEG's blocks of 64 texels take a bit or more.
constexpr int64_t kTexelsPerPngByte = 1032 * 8;
constexpr int64_t kTexelsPerJpegByte = 64 * 8;

float linearFromSrgb(float s) {
    return s <= 0.04045f ? s / 12.92f : std::pow((s + 0.055f) / 1.055f, 2.4f);
}

float clampedFactor(File& file, double value, double upper, const std::string& where,
                    const char* what) {
    const float factor = finiteFloat(file, value, where, what);
    if (value < 0.0 || value > upper) {
        file.notes.add(fmt::format("{}: {} {} is out of range and clamped", where, what, value));
    }
    return std::clamp(factor, 0.0f, static_cast<float>(upper));
}

int wrapOf(const File& file, int gl_wrap, const std::string& where) {
    switch (gl_wrap) {
        case TINYGLTF_TEXTURE_WRAP_REPEAT:
            return shared::WRAP_REPEAT;
        case TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE:
            return shared::WRAP_CLAMP;
        case TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT:
            return shared::WRAP_MIRROR;
        default:
            file.fail(where, "wrap mode {} is unknown; use 10497, 33071 or 33648", gl_wrap);
    }
}

vec3 storedTexel(const DecodedImage& image, size_t i) {
    const uint16_t* rgb = image.rgb.data() + 3 * i;
    return vec3(rgb[0], rgb[1], rgb[2]) / 65535.0f;
}

vec3 meanTexel(const DecodedImage& image) {
    const size_t count = image.rgb.size() / 3;
    glm::dvec3 sum(0.0);
    for (size_t i = 0; i < count; ++i) {
        sum += storedTexel(image, i);
    }
    return vec3(sum / static_cast<double>(count));
}

std::vector<vec3> linearTexels(const DecodedImage& image) {
    static const std::vector<float> table = [] {
        std::vector<float> linear(65536);
        for (size_t i = 0; i < linear.size(); ++i) {
            linear[i] = linearFromSrgb(static_cast<float>(i) / 65535.0f);
        }
        return linear;
    }();
    std::vector<vec3> texels(image.rgb.size() / 3);
    for (size_t i = 0; i < texels.size(); ++i) {
        const uint16_t* rgb = image.rgb.data() + 3 * i;
        texels[i] = {table[rgb[0]], table[rgb[1]], table[rgb[2]]};
    }
    return texels;
}

// Checks what an image's header says before memory is taken for it.
void checkImage(const File& file, const ImageHeader& header, size_t bytes,
                const std::string& where) {
    const int64_t texels = int64_t{header.width} * header.height;
    if (texels > kMaxTexels) {
        file.fail(where, "{} x {} texels are too many; use a smaller image", header.width,
                  header.height);
    }
    const int64_t a_byte =
        header.format == ImageFormat::kPng ? kTexelsPerPngByte : kTexelsPerJpegByte;
    if (texels / a_byte > static_cast<int64_t>(bytes)) {
        file.fail(where,
                  "its {} bytes cannot hold the {} x {} texels it promises; use an intact image",
                  bytes, header.width, header.height);
    }
    constexpr int64_t kBytesPerTexel = 18;  // as decoded, and as linear light
    checkMemory({.bytes = static_cast<uint64_t>(texels * kBytesPerTexel)},
                fmt::format("{}: {}", file.path, where), "use a smaller image");
}

DecodedImage loadImage(const File& file, int index) {
    const tinygltf::Image& source = file.model.images[static_cast<size_t>(index)];
    const std::string where = label("image", static_cast<size_t>(index), source.name);
    ByteSpan bytes{source.image.data(), source.image.size()};
    if (source.bufferView >= 0) {
        bytes = bufferViewBytes(file, source.bufferView, where);
    }
    if (bytes.size == 0) {
        file.fail(where, "{} cannot be read; put it beside the scene, or embed it",
                  source.uri.empty() ? "it" : oneLine(source.uri));
    }
    const std::span<const uint8_t> encoded(bytes.data, bytes.size);
    try {
        checkImage(file, readImageHeader(encoded), bytes.size, where);
        return decodeImage(encoded);
    } catch (const DecodeError& error) {
        file.fail(where, "it cannot be decoded: {}; use an intact PNG or JPEG",
                  oneLine(error.what()));
    }
}

// What was made of images, so that materials share it.
struct KnownImages {
    std::map<std::array<int, 3>, int> textures;  // of Scene, by (image, wrap)
    std::map<int, vec3> means;
};

// A texture whose image exists.
const tinygltf::Texture& textureAt(const File& file, int index, const std::string& owner) {
    const tinygltf::Texture& texture = file.at(file.model.textures, index, owner, "texture");
    const std::string where = fmt::format("texture {}", index);
    if (texture.source < 0 && !texture.extensions.empty()) {
        file.fail(where, "its image format ({}) is not supported; use PNG or JPEG",
                  oneLine(texture.extensions.begin()->first));
    }
    file.at(file.model.images, texture.source, where, "image");
    return texture;
}

int loadTexture(File& file, int texture_index, const std::string& owner, KnownImages& known,
                Scene& scene) {
    const tinygltf::Texture& texture = textureAt(file, texture_index, owner);
    const std::string where = fmt::format("texture {}", texture_index);
    glm::ivec2 wrap(shared::WRAP_REPEAT);
    if (texture.sampler != -1) {
        const tinygltf::Sampler& sampler =
            file.at(file.model.samplers, texture.sampler, where, "sampler");
        const std::string sampler_where = fmt::format("sampler {}", texture.sampler);
        wrap = {wrapOf(file, sampler.wrapS, sampler_where),
                wrapOf(file, sampler.wrapT, sampler_where)};
        if (sampler.magFilter == TINYGLTF_TEXTURE_FILTER_NEAREST) {
            file.notes.add("nearest filtering is not supported: texture filtered linearly");
        }
    }
    const auto [found, is_new] = known.textures.try_emplace(
        {texture.source, wrap.x, wrap.y}, static_cast<int>(scene.textures.size()));
    if (is_new) {
        const DecodedImage image = loadImage(file, texture.source);
        scene.textures.push_back({.width = image.width,
                                  .height = image.height,
                                  .texels = linearTexels(image),
                                  .wrap = wrap});
    }
    return found->second;
}

// Factors are 1 where a texture says what varies: without it all would be rough metal.
void applyMeanMetallicRoughness(File& file, int texture_index, const std::string& owner,
                                KnownImages& known, MaterialParams& params) {
    const int image = textureAt(file, texture_index, owner).source;
    const auto [mean, is_new] = known.means.try_emplace(image);
    if (is_new) {
        mean->second = meanTexel(loadImage(file, image));
    }
    params.roughness *= mean->second.g;
    params.metallic *= mean->second.b;
    file.notes.add("metallic-roughness textures are not supported: material has its mean");
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
    if (extension.Has("specularTexture") || extension.Has("specularColorTexture")) {
        file.notes.add("specular textures are not supported and left out: material affected");
    }
}

void noteUnsupported(File& file, const tinygltf::Material& source) {
    const auto note = [&](bool used, const char* what) {
        if (used) {
            file.notes.add(fmt::format("{} not supported and left out: material affected", what));
        }
    };
    note(source.normalTexture.index != -1, "normal textures are");
    note(source.occlusionTexture.index != -1, "occlusion textures are");
    if (source.emissiveTexture.index != -1) {
        file.notes.add("emissive textures are not supported: material does not emit");
    }
    if (source.alphaMode != "OPAQUE") {
        file.notes.add(fmt::format("alphaMode {} is not supported: material shown opaque",
                                   oneLine(source.alphaMode)));
    }
    const tinygltf::TextureInfo& base = source.pbrMetallicRoughness.baseColorTexture;
    note(base.extensions.count("KHR_texture_transform") > 0, "KHR_texture_transform is");
    if (base.index != -1 && base.texCoord != 0) {
        file.notes.add(fmt::format("TEXCOORD_{} is not supported: material textured by TEXCOORD_0",
                                   base.texCoord));
    }
}

Material loadMaterial(File& file, size_t index, KnownImages& known, Scene& scene) {
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
    // The factor without its texture, mostly black, would make all of the surface shine.
    double strength = source.emissiveTexture.index == -1 ? 1.0 : 0.0;
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
    if (pbr.baseColorTexture.index != -1) {
        material.base_color_texture =
            loadTexture(file, pbr.baseColorTexture.index, where, known, scene);
    }
    if (pbr.metallicRoughnessTexture.index != -1) {
        applyMeanMetallicRoughness(file, pbr.metallicRoughnessTexture.index, where, known, params);
    }
    noteUnsupported(file, source);
    return material;
}

}  // namespace

void loadMaterials(File& file, Scene& scene) {
    KnownImages known;
    for (size_t i = 0; i < file.model.materials.size(); ++i) {
        scene.materials.push_back(loadMaterial(file, i, known, scene));
    }
    scene.materials.push_back({.name = "default",
                               .params = {.base_color = vec3(1.0f),
                                          .metallic = 1.0f,
                                          .specular_color = vec3(1.0f),
                                          .specular = 1.0f,
                                          .emission = vec3(0.0f),
                                          .roughness = 1.0f}});
}

}  // namespace sheen::gltf
