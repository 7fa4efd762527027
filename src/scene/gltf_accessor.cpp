// Reading accessors: every offset, stride, count and index is checked against the bytes there are.
#include <algorithm>
#include <cmath>
#include <cstring>

#include "scene/gltf_parts.h"

namespace sheen::gltf {
namespace {

// An accessor without a buffer view is all zeros and takes no bytes, so that nothing else limits
// it: so many take 24 MiB.
constexpr size_t kMaxZeroElements = size_t{1} << 20;

const char* componentName(int type) {
    switch (type) {
        case TINYGLTF_COMPONENT_TYPE_BYTE:
            return "byte";
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
            return "unsigned byte";
        case TINYGLTF_COMPONENT_TYPE_SHORT:
            return "short";
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
            return "unsigned short";
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
            return "unsigned int";
        case TINYGLTF_COMPONENT_TYPE_FLOAT:
            return "float";
        default:
            return "an unknown type";
    }
}

bool isUnsigned(int type) {
    return type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE ||
           type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT ||
           type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT;
}

// One number at `p`, which need not be aligned. Doubles hold every component type exactly.
double readComponent(const unsigned char* p, int type) {
    const auto read = [p](auto value) {
        std::memcpy(&value, p, sizeof(value));
        return static_cast<double>(value);
    };
    switch (type) {
        case TINYGLTF_COMPONENT_TYPE_BYTE:
            return read(int8_t{});
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
            return read(uint8_t{});
        case TINYGLTF_COMPONENT_TYPE_SHORT:
            return read(int16_t{});
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
            return read(uint16_t{});
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
            return read(uint32_t{});
        default:
            return read(float{});
    }
}

double normalizeComponent(double value, int type) {
    switch (type) {
        case TINYGLTF_COMPONENT_TYPE_BYTE:
            return std::max(value / 127.0, -1.0);
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
            return value / 255.0;
        case TINYGLTF_COMPONENT_TYPE_SHORT:
            return std::max(value / 32767.0, -1.0);
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
            return value / 65535.0;
        default:
            return value;
    }
}

// Reads `count` elements of `components` numbers each from a buffer view.
std::vector<double> readView(const File& file, int buffer_view, size_t offset, size_t count,
                             int component_type, size_t components, const std::string& where) {
    const ByteSpan bytes = bufferViewBytes(file, buffer_view, where);
    const auto component_size = static_cast<size_t>(
        tinygltf::GetComponentSizeInBytes(static_cast<uint32_t>(component_type)));
    const size_t element_size = component_size * components;
    const size_t view_stride = file.model.bufferViews[static_cast<size_t>(buffer_view)].byteStride;
    const size_t stride = view_stride > 0 ? view_stride : element_size;
    // In this order nothing overflows: offset <= size, so each side stays below 2^64.
    if (offset > bytes.size || element_size > bytes.size - offset ||
        count - 1 > (bytes.size - offset - element_size) / stride) {
        file.fail(
            where,
            "{} elements of {} bytes at offset {} reach beyond the {} bytes of buffer view {}; "
            "export the file again",
            count, element_size, offset, bytes.size, buffer_view);
    }
    std::vector<double> values(count * components);
    for (size_t i = 0; i < count; ++i) {
        const unsigned char* element = bytes.data + offset + i * stride;
        for (size_t c = 0; c < components; ++c) {
            values[i * components + c] =
                readComponent(element + c * component_size, component_type);
        }
    }
    return values;
}

// Replaces the elements a sparse accessor lists.
void applySparse(const File& file, const tinygltf::Accessor& accessor, size_t components,
                 std::vector<double>& values, const std::string& where) {
    const auto& sparse = accessor.sparse;
    if (sparse.count <= 0 || sparse.indices.byteOffset < 0 || sparse.values.byteOffset < 0 ||
        static_cast<size_t>(sparse.count) > accessor.count ||
        !isUnsigned(sparse.indices.componentType)) {
        file.fail(where, "the sparse part is malformed; export the file again");
    }
    const auto count = static_cast<size_t>(sparse.count);
    const std::vector<double> indices =
        readView(file, sparse.indices.bufferView, static_cast<size_t>(sparse.indices.byteOffset),
                 count, sparse.indices.componentType, 1, where);
    const std::vector<double> replacements =
        readView(file, sparse.values.bufferView, static_cast<size_t>(sparse.values.byteOffset),
                 count, accessor.componentType, components, where);
    for (size_t i = 0; i < count; ++i) {
        const auto index = static_cast<size_t>(indices[i]);
        if (index >= accessor.count) {
            file.fail(where, "sparse index {} is out of range (count {}); export the file again",
                      index, accessor.count);
        }
        std::copy_n(replacements.begin() + static_cast<std::ptrdiff_t>(i * components), components,
                    values.begin() + static_cast<std::ptrdiff_t>(index * components));
    }
}

std::vector<double> readAccessor(const File& file, const tinygltf::Accessor& accessor,
                                 size_t components, const std::string& where) {
    if (accessor.count == 0) {
        file.fail(where, "has no elements; export the file again");
    }
    std::vector<double> values;
    if (accessor.bufferView >= 0) {
        values = readView(file, accessor.bufferView, accessor.byteOffset, accessor.count,
                          accessor.componentType, components, where);
    } else {
        if (accessor.count > kMaxZeroElements) {
            file.fail(where,
                      "has {} elements and no buffer view, which may have {}; export the "
                      "file with their values",
                      accessor.count, kMaxZeroElements);
        }
        values.assign(accessor.count * components, 0.0);
    }
    if (accessor.sparse.isSparse) {
        applySparse(file, accessor, components, values, where);
    }
    return values;
}

}  // namespace

ByteSpan bytesOf(const File& file, int index, size_t offset, size_t length,
                 const std::string& where) {
    const FileBytes& buffer = file.at(file.buffers, index, where, "buffer");
    if (!buffer.missing.empty()) {
        file.fail(fmt::format("buffer {}", index), "{}", buffer.missing);
    }
    if (offset > buffer.bytes.size() || length > buffer.bytes.size() - offset) {
        file.fail(where,
                  "{} bytes at offset {} reach beyond the {} bytes of buffer {}; the file is "
                  "truncated or wrongly written, export it again",
                  length, offset, buffer.bytes.size(), index);
    }
    return {buffer.bytes.data() + offset, length};
}

ByteSpan bufferViewBytes(const File& file, int buffer_view, const std::string& where) {
    const tinygltf::BufferView& view =
        file.at(file.model.bufferViews, buffer_view, where, "buffer view");
    return bytesOf(file, view.buffer, view.byteOffset, view.byteLength,
                   fmt::format("buffer view {}", buffer_view));
}

uint64_t accessorCount(const File& file, const tinygltf::Accessor& accessor) {
    uint64_t most = kMaxZeroElements;
    const auto view = static_cast<size_t>(accessor.bufferView);
    if (accessor.bufferView >= 0 && view < file.model.bufferViews.size()) {
        most = 0;
        const auto buffer = static_cast<size_t>(file.model.bufferViews[view].buffer);
        if (buffer < file.buffers.size()) {
            most = file.buffers[buffer].bytes.size();
        }
    }
    return std::min<uint64_t>(accessor.count, most);
}

int accessorComponents(const File& file, int accessor_index, const std::string& where) {
    switch (file.at(file.model.accessors, accessor_index, where, "accessor").type) {
        case TINYGLTF_TYPE_SCALAR:
            return 1;
        case TINYGLTF_TYPE_VEC2:
            return 2;
        case TINYGLTF_TYPE_VEC3:
            return 3;
        case TINYGLTF_TYPE_VEC4:
            return 4;
        case TINYGLTF_TYPE_MAT4:
            return 16;
        default:
            return 0;
    }
}

std::vector<double> readNumbers(const File& file, int accessor_index, const std::string& where) {
    const int components = accessorComponents(file, accessor_index, where);
    if (components == 0) {
        file.fail(where, "accessor {} is of a type that no vertex has; export the file again",
                  accessor_index);
    }
    return readAccessor(file, file.model.accessors[static_cast<size_t>(accessor_index)],
                        static_cast<size_t>(components),
                        fmt::format("{}, accessor {}", where, accessor_index));
}

std::vector<float> readFloats(const File& file, int accessor_index, int components,
                              Integers integers, const std::string& owner) {
    const tinygltf::Accessor& accessor =
        file.at(file.model.accessors, accessor_index, owner, "accessor");
    const std::string where = fmt::format("{}, accessor {}", owner, accessor_index);
    if (accessorComponents(file, accessor_index, owner) != components) {
        file.fail(where, "its type must be {}; export the file again",
                  components == 16  ? "MAT4"
                  : components == 1 ? "SCALAR"
                                    : fmt::format("VEC{}", components));
    }
    const int type = accessor.componentType;
    const bool is_float = type == TINYGLTF_COMPONENT_TYPE_FLOAT;
    const bool short_integer =
        type >= TINYGLTF_COMPONENT_TYPE_BYTE && type <= TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT;
    const bool allowed = is_float || (integers == Integers::kAny && short_integer) ||
                         (integers == Integers::kNormalizedUnsigned && short_integer &&
                          isUnsigned(type) && accessor.normalized);
    if (!allowed) {
        file.fail(where, "components must not be {}{}; export the file with floats",
                  accessor.normalized ? "normalized " : "", componentName(type));
    }
    const std::vector<double> values =
        readAccessor(file, accessor, static_cast<size_t>(components), where);
    std::vector<float> floats(values.size());
    const bool normalize = accessor.normalized && !is_float;
    std::transform(values.begin(), values.end(), floats.begin(), [&](double value) {
        return static_cast<float>(normalize ? normalizeComponent(value, type) : value);
    });
    return floats;
}

std::vector<uint32_t> readIndices(const File& file, int accessor_index, size_t vertex_count,
                                  const std::string& owner) {
    const tinygltf::Accessor& accessor =
        file.at(file.model.accessors, accessor_index, owner, "accessor");
    const std::string where = fmt::format("{}, accessor {}", owner, accessor_index);
    if (accessor.type != TINYGLTF_TYPE_SCALAR || !isUnsigned(accessor.componentType)) {
        file.fail(where, "indices must be unsigned integer scalars; export the file again");
    }
    const std::vector<double> values = readAccessor(file, accessor, 1, where);
    std::vector<uint32_t> indices(values.size());
    for (size_t i = 0; i < values.size(); ++i) {
        if (values[i] >= static_cast<double>(vertex_count)) {
            file.fail(where,
                      "index {} is out of range: the primitive has {} vertices; export the "
                      "file again",
                      values[i], vertex_count);
        }
        indices[i] = static_cast<uint32_t>(values[i]);
    }
    return indices;
}

}  // namespace sheen::gltf
