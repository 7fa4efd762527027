// Reading and parsing a glTF file, as far as tinygltf can be trusted with it.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <string_view>

#include "core/memory.h"
#include "scene/gltf_parts.h"

namespace sheen::gltf {
namespace {

constexpr int kMaxJsonDepth = 200;
constexpr size_t kGlbHeaderSize = 20;

// Extensions that are read.
const std::set<std::string> kSupported = {
    "KHR_materials_specular", "KHR_materials_emissive_strength",
    "KHR_materials_unlit",    "KHR_texture_transform",
    "KHR_lights_punctual",    "KHR_mesh_quantization",
    "EXT_mesh_gpu_instancing"};

bool isBinary(std::string_view bytes) { return bytes.substr(0, 4) == "glTF"; }

// Looks at the beginning, before memory is taken for the rest.
void checkBeginning(const std::string& path, std::string_view bytes) {
    const size_t start = bytes.find_first_not_of(" \t\r\n\xEF\xBB\xBF");
    if (!isBinary(bytes) && (start == std::string::npos || bytes[start] != '{')) {
        throwInput("{}: is neither a .glb nor a .gltf file by its content; export it again", path);
    }
}

std::string readWholeFile(const std::string& path) {
    constexpr size_t kBeginning = 4096;
    constexpr uint64_t kCopies = 3;  // as read, as parsed, as the scene
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
    if (size > std::numeric_limits<uint32_t>::max()) {
        throwInput("{}: has more than 4 GiB, which glTF cannot hold; split the scene", path);
    }
    checkMemory({.bytes = kCopies * size}, path, "split the scene");
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

// Checks a .glb file's header and returns its JSON; for other files the whole text.
std::string_view jsonOf(const std::string& path, const std::string& bytes) {
    if (!isBinary(bytes)) {
        return bytes;
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
    return std::string_view(bytes).substr(kGlbHeaderSize, json_length);
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

// Keeps an image's bytes; those in buffer views are read later, with their bounds checked.
bool keepImage(tinygltf::Image* image, const int, std::string*, std::string*, int, int,
               const unsigned char* bytes, int size, void*) {
    if (image->bufferView < 0) {
        image->image.assign(bytes, bytes + size);
    }
    return true;
}

// External files must be regular ones: a scene cannot name a device or a directory.
bool readExternal(std::vector<unsigned char>* out, std::string* error, const std::string& path,
                  void* files) {
    std::error_code code;
    if (!std::filesystem::is_regular_file(path, code)) {
        *error += fmt::format("{} is not a file", path);
        return false;
    }
    static_cast<std::vector<std::string>*>(files)->push_back(path);
    constexpr uint64_t kCopies = 2;  // as read, as decoded or in the scene
    checkMemory({.bytes = kCopies * std::filesystem::file_size(path, code)}, path,
                "split the scene");
    return tinygltf::ReadWholeFile(out, error, path, nullptr);
}

void checkRequiredExtensions(const File& file) {
    for (const std::string& name : file.model.extensionsRequired) {
        if (kSupported.count(name) == 0) {
            file.fail("extensionsRequired", "{} is not supported; export the file without it",
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
    if (!(std::abs(number) < 1e9)) {
        file.fail(where, "{} is {} and must be a small integer", key, number);
    }
    return static_cast<int>(number);
}

std::string label(const char* kind, size_t index, const std::string& name) {
    return name.empty() ? fmt::format("{} {}", kind, index)
                        : fmt::format("{} {} ({})", kind, index, oneLine(name));
}

void parse(File& file) {
    const std::string bytes = readWholeFile(file.path);
    checkNesting(file.path, jsonOf(file.path, bytes));
    tinygltf::TinyGLTF parser;
    parser.SetImageLoader(&keepImage, nullptr);
    parser.SetFsCallbacks({&tinygltf::FileExists, &tinygltf::ExpandFilePath, &readExternal,
                           &tinygltf::WriteWholeFile, &file.read});
    const std::string folder = std::filesystem::path(file.path).parent_path().string();
    const auto size = static_cast<unsigned int>(bytes.size());
    std::string error;
    std::string warning;
    bool parsed = false;
    try {
        parsed = isBinary(bytes)
                     ? parser.LoadBinaryFromMemory(
                           &file.model, &error, &warning,
                           reinterpret_cast<const unsigned char*>(bytes.data()), size, folder)
                     : parser.LoadASCIIFromString(&file.model, &error, &warning, bytes.data(), size,
                                                  folder);
    } catch (const Error&) {
        throw;
    } catch (const std::bad_alloc&) {
        throw;
    } catch (const std::exception& e) {  // of the JSON library, on values of the wrong type
        error = e.what();
    }
    // A file compressed by an extension often fails to parse for that reason: name it first.
    checkRequiredExtensions(file);
    if (!parsed) {
        file.fail("glTF", "{}; export it again", oneLine(error));
    }
    if (file.model.asset.version.compare(0, 2, "2.") != 0) {
        file.fail("asset", "is glTF version {}; export it as version 2.0",
                  oneLine(file.model.asset.version));
    }
}

void noteIgnoredParts(File& file) {
    for (const std::string& name : file.model.extensionsUsed) {
        if (kSupported.count(name) == 0) {
            file.notes.add(fmt::format("extension {} is not supported and ignored", oneLine(name)));
        }
    }
    if (!file.model.animations.empty()) {
        file.notes.add("animations are not supported: the scene is shown at rest");
    }
}

}  // namespace sheen::gltf
