// Buffer views that meshoptimizer compressed: each becomes a buffer of its own.
// Based on: EXT_meshopt_compression.
#include <meshoptimizer.h>

#include "core/memory.h"
#include "scene/gltf_parts.h"

namespace sheen::gltf {
namespace {

constexpr const char* kNames[] = {"EXT_meshopt_compression", "KHR_meshopt_compression"};

// What a view holds when it is decoded, and how it is encoded.
struct Encoding {
    size_t count = 0;
    size_t stride = 0;
    std::string mode, filter;

    bool indices() const { return mode == "TRIANGLES" || mode == "INDICES"; }
    // As the decoder demands; it trusts these.
    bool sound() const {
        if (indices()) {
            return (stride == 2 || stride == 4) && (mode == "INDICES" || count % 3 == 0) &&
                   filter == "NONE";
        }
        const bool filtered = filter == "NONE" ||
                              (filter == "OCTAHEDRAL" && (stride == 4 || stride == 8)) ||
                              (filter == "QUATERNION" && stride == 8) || filter == "EXPONENTIAL";
        return mode == "ATTRIBUTES" && stride > 0 && stride <= 256 && stride % 4 == 0 && filtered;
    }
};

std::string textMember(const tinygltf::Value& object, const char* key, const char* fallback) {
    return object.Has(key) && object.Get(key).IsString() ? object.Get(key).Get<std::string>()
                                                         : fallback;
}

int decode(const Encoding& e, ByteSpan from, void* to) {
    if (e.mode == "TRIANGLES") {
        return meshopt_decodeIndexBuffer(to, e.count, e.stride, from.data, from.size);
    }
    if (e.mode == "INDICES") {
        return meshopt_decodeIndexSequence(to, e.count, e.stride, from.data, from.size);
    }
    return meshopt_decodeVertexBuffer(to, e.count, e.stride, from.data, from.size);
}

// None where the bytes are broken.
std::vector<unsigned char> decoded(const Encoding& encoding, ByteSpan bytes) {
    std::vector<unsigned char> result(encoding.count * encoding.stride);
    if (decode(encoding, bytes, result.data()) != 0) {
        return {};
    }
    if (encoding.filter == "OCTAHEDRAL") {
        meshopt_decodeFilterOct(result.data(), encoding.count, encoding.stride);
    } else if (encoding.filter == "QUATERNION") {
        meshopt_decodeFilterQuat(result.data(), encoding.count, encoding.stride);
    } else if (encoding.filter == "EXPONENTIAL") {
        meshopt_decodeFilterExp(result.data(), encoding.count, encoding.stride);
    }
    return result;
}

FileBytes decodedView(const File& file, const tinygltf::Value& extension,
                      const std::string& where) {
    // No encoder packs more into a byte, so that little in a file cannot ask for much memory.
    constexpr uint64_t kMostOfByte = 1024;
    const auto member = [&](const char* key) {
        return static_cast<size_t>(std::max(integerMember(file, extension, key, 0, where), 0));
    };
    const ByteSpan bytes = bytesOf(file, integerMember(file, extension, "buffer", -1, where),
                                   member("byteOffset"), member("byteLength"), where);
    const Encoding encoding{.count = member("count"),
                            .stride = member("byteStride"),
                            .mode = textMember(extension, "mode", ""),
                            .filter = textMember(extension, "filter", "NONE")};
    FileBytes result;
    if (!encoding.sound() || encoding.count == 0 ||
        uint64_t{encoding.count} * encoding.stride > kMostOfByte * bytes.size) {
        result.missing = fmt::format(
            "{}: its compression (mode {}, filter {}, {} times {} bytes) is not one that is known; "
            "export the file uncompressed",
            where, oneLine(encoding.mode), oneLine(encoding.filter), encoding.count,
            encoding.stride);
        return result;
    }
    checkMemory({.bytes = uint64_t{encoding.count} * encoding.stride}, file.path,
                "split the scene");
    result.bytes = decoded(encoding, bytes);
    if (result.bytes.empty()) {
        result.missing =
            fmt::format("{}: it cannot be decompressed; copy or export the file again", where);
    }
    return result;
}

}  // namespace

void decompressViews(File& file) {
    for (size_t i = 0; i < file.model.bufferViews.size(); ++i) {
        for (const char* name : kNames) {
            tinygltf::BufferView& view = file.model.bufferViews[i];
            const auto found = view.extensions.find(name);
            if (found == view.extensions.end()) {
                continue;
            }
            FileBytes bytes =
                decodedView(file, found->second, fmt::format("buffer view {}, {}", i, name));
            view.buffer = static_cast<int>(file.buffers.size());
            view.byteOffset = 0;
            view.byteLength = bytes.bytes.size();
            file.buffers.push_back(std::move(bytes));
            break;
        }
    }
}

}  // namespace sheen::gltf
