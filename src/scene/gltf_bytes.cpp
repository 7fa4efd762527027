// The bytes of a glTF file's buffers and images, wherever they lie. tinygltf would refuse the whole
// file for an image that is not there, a data URI of a media type that it does not know, or a
// buffer that is longer than it must be.
#include <charconv>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "core/memory.h"
#include "scene/gltf_parts.h"

namespace sheen::gltf {
namespace {

using Json = nlohmann::json;

std::string textMember(const Json& object, const char* key) {
    const auto found = object.find(key);
    return found != object.end() && found->is_string() ? found->get<std::string>() : std::string();
}

// %20 and the like become what they stand for.
std::string percentDecoded(std::string_view text) {
    std::string decoded;
    for (size_t i = 0; i < text.size(); ++i) {
        unsigned char byte = 0;
        const char* digits = text.data() + i + 1;
        if (text[i] == '%' && i + 2 < text.size() &&
            std::from_chars(digits, digits + 2, byte, 16).ptr == digits + 2) {
            decoded.push_back(static_cast<char>(byte));
            i += 2;
        } else {
            decoded.push_back(text[i]);
        }
    }
    return decoded;
}

// Of "data:[media type][;base64],...", what follows the colon.
FileBytes dataUriBytes(std::string_view content) {
    constexpr std::string_view kBase64 = ";base64";
    const size_t comma = content.find(',');
    if (comma == std::string_view::npos) {
        return {.bytes = {}, .missing = "its data URI has no comma; export it again"};
    }
    const std::string_view media = content.substr(0, comma);
    const std::string data = percentDecoded(content.substr(comma + 1));
    FileBytes result;
    if (media.size() < kBase64.size() || media.substr(media.size() - kBase64.size()) != kBase64) {
        result.bytes.assign(data.begin(), data.end());
        return result;
    }
    std::string media_type;
    if (!tinygltf::DecodeDataURI(&result.bytes, media_type,
                                 "data:application/octet-stream;base64," + data, 0, false)) {
        result.missing = "its data URI is not base64; export it again";
    }
    return result;
}

// Regular files alone: a scene cannot name a device or a directory.
FileBytes fileBytes(File& file, const std::string& uri) {
    const std::filesystem::path path = std::filesystem::path(file.path).parent_path() /
                                       std::filesystem::path(percentDecoded(uri)).relative_path();
    const auto missing = [&](const char* why) {
        return FileBytes{.bytes = {},
                         .missing = fmt::format("{} {}; put it beside the scene, or embed it",
                                                oneLine(uri), why)};
    };
    std::error_code error;
    if (!std::filesystem::exists(path, error)) {
        return missing("is not there");
    }
    if (!std::filesystem::is_regular_file(path, error)) {
        return missing("is not a file");
    }
    constexpr uint64_t kCopies = 2;  // as read, as decoded or in the scene
    const uint64_t size = std::filesystem::file_size(path, error);
    checkMemory({.bytes = kCopies * size}, path.string(), "split the scene");
    FileBytes result;
    result.bytes.resize(size);
    std::ifstream in(path, std::ios::binary);
    in.read(reinterpret_cast<char*>(result.bytes.data()), static_cast<std::streamsize>(size));
    if (!in) {
        return missing("cannot be read");
    }
    file.read.push_back(path.string());
    return result;
}

FileBytes uriBytes(File& file, const std::string& uri) {
    constexpr std::string_view kData = "data:";
    return uri.compare(0, kData.size(), kData) == 0
               ? dataUriBytes(std::string_view(uri).substr(kData.size()))
               : fileBytes(file, uri);
}

}  // namespace

void readBuffers(File& file, const Json& buffers, ByteSpan chunk) {
    for (const Json& buffer : buffers) {
        const std::string where = fmt::format("buffer {}", file.buffers.size());
        const auto length = buffer.find("byteLength");
        if (length == buffer.end() || !length->is_number_unsigned()) {
            file.fail(where, "byteLength must be a count of bytes; export the file again");
        }
        const std::string uri = textMember(buffer, "uri");
        FileBytes read;
        if (!uri.empty()) {
            read = uriBytes(file, uri);
        } else if (file.buffers.empty() && chunk.data != nullptr) {
            read.bytes.assign(chunk.data, chunk.data + chunk.size);
        } else {
            read.missing = "it has no uri; export the file again";
        }
        const auto size = length->get<uint64_t>();
        if (read.missing.empty() && read.bytes.size() < size) {
            read.missing = fmt::format(
                "its byteLength is {}, but there are {} bytes; copy or export the file again", size,
                read.bytes.size());
        }
        if (read.missing.empty()) {
            read.bytes.resize(size);
        }
        file.buffers.push_back(std::move(read));
    }
}

void readImages(File& file, const Json& images) {
    for (const Json& image : images) {
        EncodedImage encoded{.name = textMember(image, "name")};
        const std::string uri = textMember(image, "uri");
        const auto view = image.find("bufferView");
        if (view != image.end() && view->is_number_unsigned() && view->get<uint64_t>() < 1u << 31) {
            encoded.buffer_view = view->get<int>();
        } else if (!uri.empty()) {
            encoded.content = uriBytes(file, uri);
        }
        if (encoded.buffer_view < 0 && encoded.content.bytes.empty() &&
            encoded.content.missing.empty()) {
            encoded.content.missing = "it is empty; export it again";
        }
        file.images.push_back(std::move(encoded));
    }
}

}  // namespace sheen::gltf
