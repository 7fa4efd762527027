// Reading and parsing a glTF file, as far as tinygltf can be trusted with it.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string_view>

#include "core/memory.h"
#include "scene/gltf_parts.h"

namespace sheen::gltf {
namespace {

constexpr int kMaxJsonDepth = 200;
constexpr size_t kGlbHeaderSize = 20;

bool isBinary(std::string_view bytes) { return bytes.substr(0, 4) == "glTF"; }

// Looks at the beginning, before memory is taken for the rest.
void checkBeginning(const std::string& path, std::string_view bytes) {
    const size_t start = bytes.find_first_not_of(" \t\r\n\xEF\xBB\xBF");
    if (!isBinary(bytes) && (start == std::string::npos || bytes[start] != '{')) {
        throwInput("{}: is neither a .glb nor a .gltf file by its content; export it again", path);
    }
}

// Before memory is taken for what the file holds.
void checkSize(const std::string& path, uint64_t size) {
    constexpr uint64_t kCopies = 4;  // as read, as parsed twice, as the scene
    if (size > std::numeric_limits<uint32_t>::max()) {
        throwInput("{}: has more than 4 GiB, which glTF cannot hold; split the scene", path);
    }
    checkMemory({.bytes = kCopies * size}, path, "split the scene");
}

std::string readWholeFile(const std::string& path) {
    constexpr size_t kBeginning = 4096;
    std::error_code error;
    const std::filesystem::file_status status = std::filesystem::status(path, error);
    if (!std::filesystem::exists(status)) {
        throwInput("{}: no such file; check the path", path);
    }
    if (std::filesystem::is_directory(status)) {
        throwInput("{}: is a directory; name the .glb or .gltf file in it", path);
    }
    if (!std::filesystem::is_regular_file(status)) {
        throwInput("{}: is not a regular file; save the scene to one", path);
    }
    const uint64_t size = std::filesystem::file_size(path, error);
    std::ifstream in(path, std::ios::binary);
    if (error || !in.is_open()) {
        throwInput("{}: cannot be read; check its permissions", path);
    }
    if (size == 0) {
        throwInput("{}: is empty; export it again", path);
    }
    std::string bytes(std::min<uint64_t>(size, kBeginning), '\0');
    in.read(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    checkBeginning(path, bytes);
    checkSize(path, size);
    const size_t read = bytes.size();
    bytes.resize(size);
    in.read(bytes.data() + read, static_cast<std::streamsize>(size - read));
    if (!in) {
        throwInput("{}: cannot be read to its end; copy or export it again", path);
    }
    return bytes;
}

uint32_t littleEndian32(const std::string& bytes, size_t offset) {
    uint32_t value = 0;
    for (size_t i = 4; i-- > 0;) {
        value = value << 8 | static_cast<unsigned char>(bytes[offset + i]);
    }
    return value;
}

// A .gltf file's text, or the parts of a .glb.
struct Document {
    std::string_view json;
    ByteSpan chunk = {};  // of no data where there is none
};

// The first binary chunk from an offset on; a .glb may hold others, unknown today.
ByteSpan binaryChunk(const std::string& path, const std::string& bytes, size_t offset) {
    constexpr uint32_t kBin = 0x004e4942;
    constexpr size_t kChunkHeaderSize = 8;
    while (offset + kChunkHeaderSize <= bytes.size()) {
        const uint32_t length = littleEndian32(bytes, offset);
        const uint32_t type = littleEndian32(bytes, offset + 4);
        offset += kChunkHeaderSize;
        if (length > bytes.size() - offset) {
            throwInput(
                "{}: header: a chunk of {} bytes reaches beyond the file; copy or export it again",
                path, length);
        }
        if (type == kBin) {
            return {reinterpret_cast<const unsigned char*>(bytes.data()) + offset, length};
        }
        offset += length;
    }
    return {};
}

// Checks a .glb file's header.
Document documentOf(const std::string& path, const std::string& bytes) {
    if (!isBinary(bytes)) {
        return {.json = bytes};
    }
    if (bytes.size() < kGlbHeaderSize) {
        throwInput("{}: header: the file ends after {} bytes; copy or export it again", path,
                   bytes.size());
    }
    const uint32_t version = littleEndian32(bytes, 4);
    if (version != 2) {
        throwInput("{}: header: is binary glTF version {}; export it as version 2", path, version);
    }
    const uint32_t length = littleEndian32(bytes, 8);
    const uint32_t json_length = littleEndian32(bytes, 12);
    if (length > bytes.size() || json_length > bytes.size() - kGlbHeaderSize) {
        throwInput(
            "{}: header: the file is truncated: it should have {} bytes and has {}; copy or "
            "export it again",
            path, std::max<uint64_t>(length, uint64_t{json_length} + kGlbHeaderSize), bytes.size());
    }
    return {.json = std::string_view(bytes).substr(kGlbHeaderSize, json_length),
            .chunk = binaryChunk(path, bytes, kGlbHeaderSize + json_length)};
}

// tinygltf copies JSON values recursively: nesting without end would overflow the stack.
void checkNesting(const std::string& path, std::string_view json) {
    int depth = 0;
    bool in_string = false;
    for (size_t i = 0; i < json.size(); ++i) {
        const char c = json[i];
        if (in_string) {
            i += c == '\\' ? 1 : 0;
            in_string = c != '"';
        } else if (c == '"') {
            in_string = true;
        } else if (c == '{' || c == '[') {
            if (++depth > kMaxJsonDepth) {
                throwInput("{}: JSON: nested more than {} deep; export it again", path,
                           kMaxJsonDepth);
            }
        } else if (c == '}' || c == ']') {
            --depth;
        }
    }
}

// Takes an array out of the document; an empty one where there is none.
nlohmann::json takeArray(nlohmann::json& document, const char* key) {
    nlohmann::json array = nlohmann::json::array();
    const auto found = document.find(key);
    if (found != document.end() && found->is_array()) {
        array = std::move(*found);
        document.erase(found);
    }
    return array;
}

// tinygltf refuses indices without a buffer view, which are zeros until a sparse part replaces
// them: all accessors without one get one more than there are, of which tinygltf asks nothing.
int lendBufferViews(nlohmann::json& document) {
    nlohmann::json& views = document["bufferViews"];
    if (!views.is_array()) {
        views = nlohmann::json::array();
    }
    const size_t lent = views.size();
    views.push_back({{"buffer", 0}, {"byteLength", 0}});
    for (nlohmann::json& accessor : document["accessors"]) {
        if (accessor.is_object() && !accessor.contains("bufferView")) {
            accessor["bufferView"] = lent;
        }
    }
    return static_cast<int>(lent);
}

void takeBackBufferViews(int lent, tinygltf::Model& model) {
    model.bufferViews.pop_back();
    for (tinygltf::Accessor& accessor : model.accessors) {
        accessor.bufferView = accessor.bufferView == lent ? -1 : accessor.bufferView;
    }
}

// Whether it has failed is told by the error's text.
std::string parseModel(nlohmann::json document, tinygltf::Model& model) {
    const int lent = lendBufferViews(document);
    const std::string text = document.dump();
    document = {};
    tinygltf::TinyGLTF parser;
    std::string error;
    std::string warning;
    try {
        if (!parser.LoadASCIIFromString(&model, &error, &warning, text.data(),
                                        static_cast<unsigned int>(text.size()), {})) {
            return error.empty() ? "it cannot be parsed" : error;
        }
    } catch (const std::bad_alloc&) {
        throw;
    } catch (const std::exception& e) {  // of the JSON library, on values of the wrong type
        return e.what();
    }
    takeBackBufferViews(lent, model);
    return {};
}

void checkRequiredExtensions(const File& file) {
    for (const std::string& name : file.model.extensionsRequired) {
        if (!isUnderstood(name)) {
            file.fail("extensionsRequired", "{} is not understood; export the file without it",
                      oneLine(name));
        }
    }
}

}  // namespace

void Notes::add(const std::string& what, int64_t count) {
    for (auto& [known, total] : notes_) {
        if (known == what) {
            total += count;
            return;
        }
    }
    notes_.emplace_back(what, count);
}

void Notes::add(const Notes& others) {
    for (const auto& [what, count] : others.notes_) {
        add(what, count);
    }
}

Notes Notes::without(const Notes& known) const {
    Notes rest;
    for (const auto& note : notes_) {
        const bool is_known =
            std::any_of(known.notes_.begin(), known.notes_.end(),
                        [&](const auto& other) { return other.first == note.first; });
        if (!is_known) {
            rest.notes_.push_back(note);
        }
    }
    return rest;
}

std::vector<std::string> Notes::lines() const {
    std::vector<std::string> lines;
    for (const auto& [what, count] : notes_) {
        lines.push_back(count == 1 ? what : fmt::format("{} ({} times)", what, count));
    }
    return lines;
}

bool File::uses(const std::string& extension) const {
    const std::vector<std::string>& used = model.extensionsUsed;
    return std::find(used.begin(), used.end(), extension) != used.end();
}

bool File::animated() const { return animations && !animations->empty(); }

float finiteFloat(const File& file, double value, const std::string& where, const char* what) {
    const auto result = static_cast<float>(value);
    if (!std::isfinite(result)) {
        file.fail(where, "{} {} is not a number that can be used; mend it", what, value);
    }
    return result;
}

double numberMember(const File& file, const tinygltf::Value& object, const std::string& key,
                    double fallback, const std::string& where) {
    if (!object.Has(key)) {
        return fallback;
    }
    const tinygltf::Value& member = object.Get(key);
    if (!member.IsNumber()) {
        file.fail(where, "{} must be a number", key);
    }
    return member.GetNumberAsDouble();
}

int integerMember(const File& file, const tinygltf::Value& object, const std::string& key,
                  int fallback, const std::string& where) {
    const double number = numberMember(file, object, key, fallback, where);
    if (!(std::abs(number) < 1e9) || number != std::trunc(number)) {
        file.fail(where, "{} is {} and must be a small integer", key, number);
    }
    return static_cast<int>(number);
}

std::string label(const char* kind, size_t index, const std::string& name) {
    return name.empty() ? fmt::format("{} {}", kind, index)
                        : fmt::format("{} {} ({})", kind, index, oneLine(name));
}

std::string jsonOf(const std::string& path) {
    const std::string bytes = readWholeFile(path);
    return std::string(documentOf(path, bytes).json);
}

void parse(File& file) {
    if (file.bytes.empty()) {
        file.bytes = readWholeFile(file.path);
    } else {
        checkBeginning(file.path, file.bytes);
        checkSize(file.path, file.bytes.size());
    }
    const std::string bytes = std::move(file.bytes);
    const Document parts = documentOf(file.path, bytes);
    checkNesting(file.path, parts.json);
    nlohmann::json document;
    try {
        document = nlohmann::json::parse(parts.json);
    } catch (const nlohmann::json::exception& e) {
        file.fail("glTF", "{}; export it again", oneLine(e.what()));
    }
    if (!document.is_object()) {
        file.fail("glTF", "its JSON is not an object; export it again");
    }
    const nlohmann::json buffers = takeArray(document, "buffers");
    const nlohmann::json images = takeArray(document, "images");
    file.animations = std::make_shared<const nlohmann::json>(takeArray(document, "animations"));
    const std::string error = parseModel(std::move(document), file.model);
    // A file that an extension changes often fails to parse for that reason: name it first.
    checkRequiredExtensions(file);
    if (!error.empty()) {
        file.fail("glTF", "{}; export it again", oneLine(error));
    }
    if (file.model.asset.version.compare(0, 2, "2.") != 0) {
        file.fail("asset", "is glTF version {}; export it as version 2.0",
                  oneLine(file.model.asset.version));
    }
    readBuffers(file, buffers, parts.chunk);
    readImages(file, images);
    decompressViews(file);
    decompressMeshes(file);
}

}  // namespace sheen::gltf
