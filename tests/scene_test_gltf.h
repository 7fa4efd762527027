// Writes small glTF files for the loader's tests: a JSON document that a test may change at will,
// and one binary buffer.
#pragma once

#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "core/error.h"
#include "scene/scene.h"
#include "scenes/png.h"
#include "test_folder.h"

namespace sheen {

using Json = nlohmann::json;

constexpr int kByte = 5120;
constexpr int kUnsignedByte = 5121;
constexpr int kUnsignedShort = 5123;
constexpr int kUnsignedInt = 5125;
constexpr int kFloat = 5126;

/// A path for this test alone, in a folder that goes away with the process.
inline std::string temporaryPath(const std::string& name) {
    const auto* test = testing::UnitTest::GetInstance()->current_test_info();
    static const TestFolder all;
    const std::filesystem::path folder = all.path() / test->test_suite_name() / test->name();
    std::filesystem::create_directories(folder);
    return (folder / name).string();
}

inline void writeFile(const std::string& path, const std::string& bytes) {
    std::ofstream(path, std::ios::binary) << bytes;
}

struct GltfFile {
    Json json = {{"asset", {{"version", "2.0"}}}};
    std::string binary;

    template <class T>
    int addView(const std::vector<T>& values) {
        const size_t offset = binary.size();
        binary.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
        json["bufferViews"].push_back(
            {{"buffer", 0}, {"byteOffset", offset}, {"byteLength", values.size() * sizeof(T)}});
        binary.resize((binary.size() + 3) / 4 * 4);
        return static_cast<int>(json["bufferViews"].size()) - 1;
    }

    template <class T>
    int addAccessor(const std::vector<T>& values, int component_type, const char* type,
                    int components) {
        json["accessors"].push_back({{"bufferView", addView(values)},
                                     {"componentType", component_type},
                                     {"count", values.size() / static_cast<size_t>(components)},
                                     {"type", type}});
        return static_cast<int>(json["accessors"].size()) - 1;
    }

    /// A mesh of one primitive, and a node that shows it.
    Json& addPrimitive(const std::vector<float>& positions) {
        const int accessor = addAccessor(positions, kFloat, "VEC3", 3);
        json["meshes"].push_back(
            {{"primitives", Json::array({{{"attributes", {{"POSITION", accessor}}}}})}});
        json["nodes"].push_back({{"mesh", json["meshes"].size() - 1}});
        return json["meshes"].back()["primitives"][0];
    }

    std::string glb() const {
        Json document = json;
        if (!binary.empty() && !document.contains("buffers")) {
            document["buffers"] = Json::array({{{"byteLength", binary.size()}}});
        }
        std::string text = document.dump();
        text.resize((text.size() + 3) / 4 * 4, ' ');
        const auto word = [](size_t value) {
            const auto number = static_cast<uint32_t>(value);
            return std::string(reinterpret_cast<const char*>(&number), 4);
        };
        std::string chunks = word(text.size()) + "JSON" + text;
        if (!binary.empty()) {
            chunks += word(binary.size()) + std::string("BIN\0", 4) + binary;
        }
        return "glTF" + word(2) + word(12 + chunks.size()) + chunks;
    }

    std::string write() const {
        const std::string path = temporaryPath("scene.glb");
        writeFile(path, glb());
        return path;
    }

    Scene load() const { return loadScene(write()); }
};

/// One triangle in the plane z = 0, facing +z, with corners (0,0), (1,0), (0,1).
inline const std::vector<float> kTriangle = {0, 0, 0, 1, 0, 0, 0, 1, 0};

inline GltfFile oneTriangle() {
    GltfFile file;
    file.addPrimitive(kTriangle);
    return file;
}

/// Adds a texture of such an image, and returns its index.
inline int addPicture(GltfFile& file, const scenes::Picture& picture) {
    Json& json = file.json;
    json["images"].push_back(
        {{"bufferView", file.addView(scenes::encodePng(picture))}, {"mimeType", "image/png"}});
    json["textures"].push_back({{"source", json["images"].size() - 1}});
    return static_cast<int>(json["textures"].size()) - 1;
}

/// A triangle with a 2 x 2 texture: black, white / mid grey, red.
inline GltfFile textured() {
    GltfFile file = oneTriangle();
    addPicture(file, {2, 2, {{{0, 0, 0}}, {{255, 255, 255}}, {{128, 128, 128}}, {{255, 0, 0}}}});
    file.json["samplers"] = Json::array({{{"wrapS", 33071}, {"wrapT", 33648}}});
    file.json["textures"][0]["sampler"] = 0;
    file.json["materials"] =
        Json::array({{{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 0}}}}}}});
    Json& primitive = file.json["meshes"][0]["primitives"][0];
    primitive["material"] = 0;
    primitive["attributes"]["TEXCOORD_0"] =
        file.addAccessor<float>({0, 0, 1, 0, 0, 1}, kFloat, "VEC2", 2);
    return file;
}

/// A file that uses one of everything that is checked.
inline GltfFile sound() {
    GltfFile file = oneTriangle();
    Json& primitive = file.json["meshes"][0]["primitives"][0];
    primitive["indices"] = file.addAccessor<uint16_t>({0, 1, 2}, kUnsignedShort, "SCALAR", 1);
    primitive["attributes"]["NORMAL"] =
        file.addAccessor<float>({0, 0, 1, 0, 0, 1, 0, 0, 1}, kFloat, "VEC3", 3);
    primitive["attributes"]["TEXCOORD_0"] =
        file.addAccessor<float>({0, 0, 1, 0, 0, 1}, kFloat, "VEC2", 2);
    primitive["material"] = 0;
    file.json["images"] = Json::array(
        {{{"bufferView", file.addView<uint8_t>({1, 2, 3, 4})}, {"mimeType", "image/png"}}});
    file.json["samplers"] = Json::array({Json::object()});
    file.json["textures"] = Json::array({{{"source", 0}, {"sampler", 0}}});
    file.json["materials"] = Json::array({{{"name", "paint"}}});
    file.json["cameras"] =
        Json::array({{{"type", "perspective"}, {"perspective", {{"yfov", 0.8}, {"znear", 0.1}}}}});
    file.json["extensions"]["KHR_lights_punctual"]["lights"] = Json::array({{{"type", "point"}}});
    file.json["nodes"].push_back({{"camera", 0}});
    file.json["nodes"].push_back({{"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}});
    return file;
}

/// Whether a warning contains `text`.
inline bool warnsOf(const Scene& scene, const std::string& text) {
    for (const std::string& warning : scene.warnings) {
        if (warning.find(text) != std::string::npos) {
            return true;
        }
    }
    return false;
}

}  // namespace sheen
