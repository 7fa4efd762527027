// Meshes that Draco compressed: what each of their accessors describes becomes a buffer of its own.
// Based on: KHR_draco_mesh_compression.
#include <draco/compression/decode.h>

#include <algorithm>
#include <cstring>
#include <exception>
#include <limits>
#include <optional>

#include "core/memory.h"
#include "scene/gltf_parts.h"

namespace sheen::gltf {
namespace {

constexpr const char* kDraco = "KHR_draco_mesh_compression";

// A mesh's accessor in its stored type, one element after the other; none where the decoder has no
// such numbers.
template <class T>
std::optional<std::vector<unsigned char>> valuesOf(const draco::PointAttribute& attribute,
                                                   uint32_t points, int components) {
    const size_t size = static_cast<size_t>(components) * sizeof(T);
    std::vector<unsigned char> bytes(points * size);
    std::vector<T> value(static_cast<size_t>(components));
    for (uint32_t i = 0; i < points; ++i) {
        const draco::AttributeValueIndex index = attribute.mapped_index(draco::PointIndex(i));
        if (index.value() >= attribute.size() ||
            !attribute.ConvertValue(index, static_cast<int8_t>(components), value.data())) {
            return std::nullopt;
        }
        std::memcpy(&bytes[i * size], value.data(), size);
    }
    return bytes;
}

std::optional<std::vector<unsigned char>> storedValues(const draco::PointAttribute& attribute,
                                                       uint32_t points, int type, int components) {
    switch (type) {
        case TINYGLTF_COMPONENT_TYPE_BYTE:
            return valuesOf<int8_t>(attribute, points, components);
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
            return valuesOf<uint8_t>(attribute, points, components);
        case TINYGLTF_COMPONENT_TYPE_SHORT:
            return valuesOf<int16_t>(attribute, points, components);
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
            return valuesOf<uint16_t>(attribute, points, components);
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
            return valuesOf<uint32_t>(attribute, points, components);
        case TINYGLTF_COMPONENT_TYPE_FLOAT:
            return valuesOf<float>(attribute, points, components);
        default:
            return std::nullopt;
    }
}

// A number as Draco stores it, seven bits a byte.
uint64_t takeVarint(ByteSpan& bytes) {
    uint64_t number = 0;
    for (int shift = 0; shift < 35 && bytes.size > 0; shift += 7) {
        const unsigned char byte = *bytes.data++;
        --bytes.size;
        number |= uint64_t{byte & 0x7fu} << shift;
        if (byte < 0x80) {
            return number;
        }
    }
    return std::numeric_limits<uint64_t>::max();  // none
}

// The more of vertices and faces that a stream of version 2.2 promises; the decoder takes memory
// for as many before it looks for them. 0 for other versions, and where metadata come first.
uint64_t promisedCount(ByteSpan bytes) {
    constexpr size_t kHeader = 11;  // magic, version, kind, method, flags
    constexpr unsigned char kMetadata = 0x80;
    if (bytes.size < kHeader + 1 || bytes.data[5] != 2 || bytes.data[6] != 2 ||
        (bytes.data[10] & kMetadata) != 0) {
        return 0;
    }
    const bool edgebreaker = bytes.data[8] == 1;
    const size_t begin = kHeader + (edgebreaker ? 1 : 0);  // which traversal
    ByteSpan rest{bytes.data + begin, bytes.size - begin};
    const uint64_t first = takeVarint(rest);
    return std::max(first, takeVarint(rest));
}

// A mesh; null where the bytes are broken.
std::unique_ptr<draco::Mesh> decoded(ByteSpan bytes) {
    draco::DecoderBuffer buffer;
    buffer.Init(reinterpret_cast<const char*>(bytes.data), bytes.size);
    try {
        auto mesh = draco::Decoder().DecodeMeshFromBuffer(&buffer);
        return mesh.ok() ? std::move(mesh).value() : nullptr;
    } catch (const std::exception&) {
        return nullptr;  // it promised more than there can be
    }
}

// The accessor then reads these bytes.
void give(File& file, tinygltf::Accessor& accessor, std::vector<unsigned char> bytes) {
    tinygltf::BufferView view;
    view.buffer = static_cast<int>(file.buffers.size());
    view.byteLength = bytes.size();
    accessor.bufferView = static_cast<int>(file.model.bufferViews.size());
    accessor.byteOffset = 0;
    file.model.bufferViews.push_back(std::move(view));
    file.buffers.push_back({.bytes = std::move(bytes)});
}

// Whether that is an accessor whose numbers only the compressed mesh has.
bool lacksNumbers(const File& file, int accessor) {
    return accessor >= 0 && static_cast<size_t>(accessor) < file.model.accessors.size() &&
           file.model.accessors[static_cast<size_t>(accessor)].bufferView < 0;
}

bool lacksNumbers(const File& file, const tinygltf::Primitive& primitive) {
    return lacksNumbers(file, primitive.indices) ||
           std::any_of(primitive.attributes.begin(), primitive.attributes.end(),
                       [&](const auto& a) { return lacksNumbers(file, a.second); });
}

class CompressedPrimitive {
  public:
    CompressedPrimitive(File& file, tinygltf::Primitive& primitive,
                        const tinygltf::Value& extension, std::string where)
        : file_(file), primitive_(primitive), extension_(extension), where_(std::move(where)) {}

    void decompress() {
        const ByteSpan bytes = bufferViewBytes(
            file_, integerMember(file_, extension_, "bufferView", -1, where_), where_);
        checkCounts(bytes);
        mesh_ = decoded(bytes);
        if (!mesh_) {
            file_.fail(where_, "{} cannot be decompressed; copy or export the file again", kDraco);
        }
        for (const auto& [name, accessor] : primitive_.attributes) {
            giveAttribute(name, accessor);
        }
        giveIndices();
    }

  private:
    // No encoder packs more vertices into a byte, so that little in a file cannot ask for much.
    void checkCounts(ByteSpan bytes) const {
        constexpr uint64_t kMostOfByte = 1024;
        if (promisedCount(bytes) > kMostOfByte * bytes.size) {
            file_.fail(where_, "{} of {} bytes cannot hold what it promises; export the file again",
                       kDraco, bytes.size);
        }
        for (const auto& [name, accessor] : primitive_.attributes) {
            const uint64_t count =
                file_.at(file_.model.accessors, accessor, where_, "accessor").count;
            if (count > kMostOfByte * bytes.size) {
                file_.fail(where_, "{} of {} bytes cannot hold {} vertices; export the file again",
                           kDraco, bytes.size, count);
            }
            checkMemory({.bytes = count * sizeof(vec4)}, file_.path, "split the scene");
        }
    }

    void giveAttribute(const std::string& name, int index) {
        if (!lacksNumbers(file_, index)) {
            return;
        }
        const tinygltf::Value& ids = extension_.Get("attributes");
        if (!ids.IsObject() || !ids.Has(name)) {
            return;  // zeros, as the format has it
        }
        const int id = integerMember(file_, ids, name, -1, where_);
        const draco::PointAttribute* attribute =
            id < 0 ? nullptr : mesh_->GetAttributeByUniqueId(static_cast<uint32_t>(id));
        tinygltf::Accessor& accessor = file_.model.accessors[static_cast<size_t>(index)];
        const int components = accessorComponents(file_, index, where_);
        auto values =
            attribute == nullptr || components < 1 || components > 4 ||
                    accessor.count != mesh_->num_points()
                ? std::nullopt
                : storedValues(*attribute, mesh_->num_points(), accessor.componentType, components);
        if (!values) {
            file_.fail(where_, "{} and accessor {} ({}) do not agree; export the file again",
                       kDraco, index, oneLine(name));
        }
        give(file_, accessor, std::move(*values));
    }

    // Always triangles, in integers that hold any number.
    void giveIndices() {
        std::vector<uint32_t> indices;
        for (draco::FaceIndex f(0); f < mesh_->num_faces(); ++f) {
            for (const draco::PointIndex& corner : mesh_->face(f)) {
                indices.push_back(corner.value());
            }
        }
        tinygltf::Accessor accessor;
        accessor.type = TINYGLTF_TYPE_SCALAR;
        accessor.componentType = TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
        accessor.count = indices.size();
        std::vector<unsigned char> bytes(sizeof(uint32_t) * indices.size());
        std::memcpy(bytes.data(), indices.data(), bytes.size());
        give(file_, accessor, std::move(bytes));
        primitive_.indices = static_cast<int>(file_.model.accessors.size());
        primitive_.mode = TINYGLTF_MODE_TRIANGLES;
        file_.model.accessors.push_back(std::move(accessor));
    }

    File& file_;
    tinygltf::Primitive& primitive_;
    const tinygltf::Value& extension_;
    const std::string where_;
    std::unique_ptr<draco::Mesh> mesh_;
};

}  // namespace

void decompressMeshes(File& file) {
    for (size_t m = 0; m < file.model.meshes.size(); ++m) {
        tinygltf::Mesh& mesh = file.model.meshes[m];
        for (size_t i = 0; i < mesh.primitives.size(); ++i) {
            tinygltf::Primitive& primitive = mesh.primitives[i];
            const auto extension = primitive.extensions.find(kDraco);
            if (extension != primitive.extensions.end() && lacksNumbers(file, primitive)) {
                const std::string where =
                    fmt::format("{}, primitive {}", label("mesh", m, mesh.name), i);
                CompressedPrimitive(file, primitive, extension->second, where).decompress();
            }
        }
    }
}

}  // namespace sheen::gltf
