// Textures: images, each decoded once however many materials show it, and how they are looked up.
#include <algorithm>
#include <cmath>

#include "core/memory.h"
#include "image/decode.h"
#include "scene/gltf_parts.h"

namespace sheen::gltf {
namespace {

// An image of more texels is left out.
constexpr int64_t kMaxTexels = int64_t{1} << 27;
// What a byte of a file can hold at most: zlib packs 1032 bytes of 8 texels each into one, and
// JPEG's blocks of 64 texels take a bit or more. WebP needs nothing for a texel of one colour.
constexpr int64_t kTexelsPerPngByte = 1032 * 8;
constexpr int64_t kTexelsPerJpegByte = 64 * 8;

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

// Checks what an image's header says before memory is taken for it.
void checkImage(const File& file, const ImageHeader& header, size_t bytes,
                const std::string& where) {
    const int64_t texels = int64_t{header.width} * header.height;
    if (texels > kMaxTexels) {
        throw DecodeError(fmt::format("{} x {} texels are too many", header.width, header.height));
    }
    const int64_t a_byte = header.format == ImageFormat::kPng    ? kTexelsPerPngByte
                           : header.format == ImageFormat::kJpeg ? kTexelsPerJpegByte
                                                                 : kMaxTexels;
    if (texels / a_byte > static_cast<int64_t>(bytes)) {
        throw DecodeError(fmt::format("its {} bytes cannot hold the {} x {} texels it promises",
                                      bytes, header.width, header.height));
    }
    constexpr int64_t kBytesPerTexel = 16;  // as decoded, and as kept
    checkMemory({.bytes = static_cast<uint64_t>(texels * kBytesPerTexel)},
                fmt::format("{}: {}", file.path, where), "use a smaller image");
}

// Of 8 bits a channel where that loses nothing.
TextureImage storedImage(DecodedImage image) {
    constexpr uint16_t kWords = 257;  // to a byte
    TextureImage stored{.width = image.width, .height = image.height};
    const bool bytes = std::all_of(image.rgba.begin(), image.rgba.end(),
                                   [](uint16_t word) { return word % kWords == 0; });
    if (!bytes) {
        stored.words = std::move(image.rgba);
        return stored;
    }
    stored.bytes.resize(image.rgba.size());
    std::transform(image.rgba.begin(), image.rgba.end(), stored.bytes.begin(),
                   [](uint16_t word) { return static_cast<uint8_t>(word / kWords); });
    return stored;
}

std::span<const uint8_t> encodedBytes(const File& file, const EncodedImage& image,
                                      const std::string& where) {
    const ByteSpan bytes = image.buffer_view >= 0
                               ? bufferViewBytes(file, image.buffer_view, where)
                               : ByteSpan{image.content.bytes.data(), image.content.bytes.size()};
    return {bytes.data, bytes.size};
}

// Bytes that images take, halved to sides of at most so many texels, with their smaller copies.
uint64_t keptBytes(const std::vector<ImageHeader>& headers, int side) {
    uint64_t texels = 0;
    for (const ImageHeader& header : headers) {
        ivec2 size(header.width, header.height);
        while (std::max(size.x, size.y) > side) {
            size = glm::max(size / 2, 1);
        }
        texels += static_cast<uint64_t>(size.x) * static_cast<uint64_t>(size.y);
    }
    return 4 * texels * 4 / 3;
}

// How large the sides of images may be for all of the file's together to take 1.25 GiB, of 8 bits.
int largestSide(File& file) {
    constexpr uint64_t kMost = uint64_t{5} << 28;
    constexpr int kLargest = 1 << 20;
    constexpr int kSmallest = 64;
    std::vector<ImageHeader> headers;
    for (size_t i = 0; i < file.images.size(); ++i) {
        if (file.images[i].content.missing.empty()) {
            try {
                headers.push_back(readImageHeader(
                    encodedBytes(file, file.images[i], label("image", i, file.images[i].name))));
            } catch (const std::exception&) {
                continue;  // whoever needs it will say so
            }
        }
    }
    const uint64_t whole = keptBytes(headers, kLargest);
    if (whole <= kMost) {
        return kLargest;
    }
    int side = kLargest;
    while (side > kSmallest && keptBytes(headers, side) > kMost) {
        side /= 2;
    }
    file.notes.add(
        fmt::format("the images would take {:.1f} GiB: they are kept at no more than {} texels a "
                    "side; use fewer or smaller ones to see them whole",
                    static_cast<double>(whole) / static_cast<double>(uint64_t{1} << 30), side));
    return side;
}

// Of the extension for WebP before the texture's own, which is for who does not know it.
int imageOf(const File& file, const tinygltf::Texture& texture, const std::string& where) {
    const auto webp = texture.extensions.find("EXT_texture_webp");
    return webp == texture.extensions.end()
               ? texture.source
               : integerMember(file, webp->second, "source", texture.source, where);
}

vec2 pairMember(const File& file, const tinygltf::Value& object, const char* key,
                const vec2& fallback, const std::string& where) {
    if (!object.Has(key)) {
        return fallback;
    }
    const tinygltf::Value& member = object.Get(key);
    if (member.ArrayLen() != 2 || !member.Get(0).IsNumber() || !member.Get(1).IsNumber()) {
        file.fail(where, "{} must hold two numbers", key);
    }
    return {finiteFloat(file, member.Get(0).GetNumberAsDouble(), where, key),
            finiteFloat(file, member.Get(1).GetNumberAsDouble(), where, key)};
}

// uv' = offset + rotation * scale * uv; the image's rows run downward, and so does v.
void readTransform(const File& file, const tinygltf::Value& extension, const std::string& where,
                   TextureUse& use) {
    const vec2 scale = pairMember(file, extension, "scale", vec2(1.0f), where);
    const double angle =
        finiteFloat(file, numberMember(file, extension, "rotation", 0.0, where), where, "rotation");
    const auto cosine = static_cast<float>(std::cos(angle));
    const auto sine = static_cast<float>(std::sin(angle));
    use.transform = {.row_u = vec2(cosine, sine) * scale,
                     .row_v = vec2(-sine, cosine) * scale,
                     .offset = pairMember(file, extension, "offset", vec2(0.0f), where)};
}

}  // namespace

std::optional<TextureImage> loadImage(File& file, int index, const char* loss, int longest) {
    const EncodedImage& source = file.images[static_cast<size_t>(index)];
    const std::string where = label("image", static_cast<size_t>(index), source.name);
    if (!source.content.missing.empty()) {
        file.notes.add(fmt::format("{}: {}: {}", where, loss, source.content.missing));
        return std::nullopt;
    }
    const std::span<const uint8_t> encoded = encodedBytes(file, source, where);
    try {
        const ImageHeader header = readImageHeader(encoded);
        if (std::max(header.width, header.height) > longest) {
            throw DecodeError(fmt::format("{} x {} texels are too many, of at most {} a side",
                                          header.width, header.height, longest));
        }
        checkImage(file, header, encoded.size(), where);
        return storedImage(decodeImage(encoded));
    } catch (const DecodeError& error) {
        file.notes.add(
            fmt::format("{}: it cannot be decoded: {}: {}; use an intact PNG, JPEG or WebP", where,
                        oneLine(error.what()), loss));
        return std::nullopt;
    }
}

TextureInfo textureInfo(const File& file, const tinygltf::Value& object, const std::string& where) {
    TextureInfo info;
    info.index = integerMember(file, object, "index", -1, where);
    info.uv_set = integerMember(file, object, "texCoord", 0, where);
    if (object.Has("extensions") && object.Get("extensions").Has("KHR_texture_transform")) {
        info.transform = object.Get("extensions").Get("KHR_texture_transform");
    }
    return info;
}

TextureLoader::TextureLoader(File& file, Scene& scene)
    : file_(file), scene_(scene), largest_side_(largestSide(file)) {}

int TextureLoader::load(int index, bool srgb, const std::string& owner) {
    const tinygltf::Texture& source = file_.at(file_.model.textures, index, owner, "texture");
    const std::string where = fmt::format("texture {}", index);
    const int own_image = imageOf(file_, source, where);
    if (own_image < 0) {
        file_.notes.add(source.extensions.empty()
                            ? fmt::format("{} has no image: materials shown without it", where)
                            : fmt::format("{}: its image format ({}) is not supported: materials "
                                          "shown without it; use PNG, JPEG or WebP",
                                          where, oneLine(source.extensions.begin()->first)));
        return -1;
    }
    file_.at(file_.images, own_image, where, "image");
    const auto [image, is_new] = images_.try_emplace(own_image, -1);
    if (is_new) {
        if (auto loaded = loadImage(file_, own_image, "materials shown without it")) {
            while (std::max(loaded->width, loaded->height) > largest_side_) {
                loaded = halved(*loaded, srgb);
            }
            scene_.images.push_back(std::move(*loaded));
            image->second = static_cast<int>(scene_.images.size()) - 1;
        }
    }
    bool smaller = true;  // unless the sampler asks for the image alone, at any distance
    Texture texture{.image = image->second, .srgb = srgb};
    if (source.sampler != -1) {
        const tinygltf::Sampler& sampler =
            file_.at(file_.model.samplers, source.sampler, where, "sampler");
        const std::string sampler_where = fmt::format("sampler {}", source.sampler);
        texture.wrap = {wrapOf(file_, sampler.wrapS, sampler_where),
                        wrapOf(file_, sampler.wrapT, sampler_where)};
        texture.nearest = sampler.magFilter == TINYGLTF_TEXTURE_FILTER_NEAREST;
        smaller = sampler.minFilter != TINYGLTF_TEXTURE_FILTER_NEAREST &&
                  sampler.minFilter != TINYGLTF_TEXTURE_FILTER_LINEAR;
    }
    if (texture.image < 0) {
        return -1;
    }
    if (smaller) {
        makeSmaller(scene_.images[static_cast<size_t>(texture.image)], srgb);
    }
    const auto known = std::find(scene_.textures.begin(), scene_.textures.end(), texture);
    if (known == scene_.textures.end()) {
        scene_.textures.push_back(texture);
        return static_cast<int>(scene_.textures.size()) - 1;
    }
    return static_cast<int>(known - scene_.textures.begin());
}

template <class Read>
TextureUse TextureLoader::unlessBroken(const TextureInfo& info, const Read& read) {
    if (info.index == -1) {
        return {};
    }
    try {
        return read();
    } catch (const Error& error) {
        if (error.code() != ExitCode::kInput) {
            throw;
        }
        // What fails names the file first, which notes need not.
        file_.notes.add(fmt::format("{}: material shown without that texture",
                                    std::string(error.what()).substr(file_.path.size() + 2)));
        return {};
    }
}

TextureUse TextureLoader::use(const TextureInfo& info, bool srgb, const std::string& owner) {
    return unlessBroken(info, [&] { return usable(info, srgb, owner); });
}

TextureUse TextureLoader::useLightmap(const TextureInfo& info, const std::string& owner) {
    return unlessBroken(info, [&] {
        TextureUse use = placed(info, owner);
        use.texture = load(info.index, false, owner);
        return use;
    });
}

// Of an image in linear light whose green is green(texel), blue and alpha white.
template <class Green>
TextureUse TextureLoader::remade(const TextureUse& use, const Green& green) {
    Texture texture = scene_.textures[static_cast<size_t>(use.texture)];
    const TextureImage& source = scene_.images[static_cast<size_t>(texture.image)];
    TextureImage image{.width = source.width, .height = source.height};
    image.bytes.reserve(4 * source.texelCount());
    for (int y = 0; y < source.height; ++y) {
        for (int x = 0; x < source.width; ++x) {
            const float value = green(texelOf(source, false, x, y));
            const auto byte = static_cast<uint8_t>(std::lround(255.0f * value));
            image.bytes.insert(image.bytes.end(), {0, byte, 255, 255});
        }
    }
    makeSmaller(image, false);
    scene_.images.push_back(std::move(image));
    texture.image = static_cast<int>(scene_.images.size()) - 1;
    texture.srgb = false;
    scene_.textures.push_back(texture);
    TextureUse result = use;
    result.texture = static_cast<int>(scene_.textures.size()) - 1;
    return result;
}

TextureUse TextureLoader::roughnessOf(const TextureUse& gloss, float glossiness) {
    return remade(gloss, [&](const vec4& texel) { return 1.0f - glossiness * texel.w; });
}

TextureUse TextureLoader::withGreenBetween(const TextureUse& use, float lower, float upper) {
    return remade(use, [&](const vec4& texel) { return glm::mix(lower, upper, texel.y); });
}

// Where it is looked up, by coordinates of any set. Input error where any part of it is broken.
TextureUse TextureLoader::placed(const TextureInfo& info, const std::string& owner) const {
    TextureUse use;
    use.uv_set = info.uv_set;
    if (info.transform.IsObject()) {
        readTransform(file_, info.transform, owner, use);
        use.uv_set = integerMember(file_, info.transform, "texCoord", use.uv_set, owner);
    }
    return use;
}

// Likewise.
TextureUse TextureLoader::usable(const TextureInfo& info, bool srgb, const std::string& owner) {
    TextureUse use = placed(info, owner);
    if (use.uv_set != 0 && use.uv_set != 1) {
        file_.notes.add(fmt::format("TEXCOORD_{} is not supported: material textured by TEXCOORD_0",
                                    use.uv_set));
        use.uv_set = 0;
    }
    use.texture = load(info.index, srgb, owner);
    return use;
}

}  // namespace sheen::gltf
