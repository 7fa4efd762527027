// Small sound scenes that use everything the loader reads.
#include "encoded_images.h"
#include "fuzz/seeds.h"
#include "scene_test_gltf.h"
#include "scenes/all_scenes.h"
#include "scenes/png.h"

namespace sheen::fuzz {
namespace {

scenes::Picture picture() {
    scenes::Picture picture{.width = 3, .height = 2, .pixels = {}};
    picture.pixels.assign(6, {200, 100, 50});
    return picture;
}

// The scene with all that is checked, and what it is not.
GltfFile textured() {
    GltfFile file = sound();
    Json& json = file.json;
    json["images"][0] = {{"bufferView", file.addView(scenes::encodePng(picture()))},
                         {"mimeType", "image/png"}};
    const std::vector<uint8_t> grey(8 * 8 * 3, 120);
    json["images"].push_back(
        {{"bufferView", file.addView(encodeJpeg(grey, 8, 3))}, {"mimeType", "image/jpeg"}});
    json["textures"].push_back({{"source", 1}});
    json["materials"][0]["pbrMetallicRoughness"] = {{"baseColorTexture", {{"index", 0}}},
                                                    {"metallicFactor", 0.5},
                                                    {"roughnessFactor", 0.3},
                                                    {"baseColorFactor", {0.5, 0.6, 0.7, 1.0}}};
    json["materials"].push_back(
        {{"emissiveFactor", {1.0, 0.5, 0.25}},
         {"pbrMetallicRoughness", {{"baseColorTexture", {{"index", 1}}}}},
         {"extensions",
          {{"KHR_materials_specular",
            {{"specularFactor", 0.5}, {"specularColorFactor", {0.1, 0.2, 0.3}}}},
           {"KHR_materials_emissive_strength", {{"emissiveStrength", 10.0}}}}}});
    return file;
}

GltfFile transformed() {
    GltfFile file = sound();
    Json& json = file.json;
    json["nodes"][0]["translation"] = {1.0, 2.0, 3.0};
    json["nodes"][0]["rotation"] = {0.0, 0.7, 0.0, 0.7};
    json["nodes"][0]["scale"] = {1.0, -2.0, 0.5};
    json["nodes"][1]["matrix"] = {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 4, 5, 6, 1};
    json["nodes"].push_back({{"children", {0, 1, 2}}});
    json["scenes"] = Json::array({{{"nodes", {3}}}});
    json["scene"] = 0;
    json["extensions"]["KHR_lights_punctual"]["lights"][0] = {
        {"type", "spot"},
        {"intensity", 5.0},
        {"range", 9.0},
        {"color", {1.0, 0.5, 0.2}},
        {"spot", {{"innerConeAngle", 0.2}, {"outerConeAngle", 0.6}}}};
    return file;
}

GltfFile quantized() {
    GltfFile file = oneTriangle();
    Json& json = file.json;
    json["extensionsUsed"] = {"KHR_mesh_quantization"};
    json["accessors"][0] = {{"bufferView", file.addView<int8_t>({0, 0, 0, 0, 9, 0, 0, 0, 0, 9, 0})},
                            {"componentType", kByte},
                            {"count", 3},
                            {"type", "VEC3"}};
    json["bufferViews"].back()["byteStride"] = 4;
    json["accessors"].push_back(json["accessors"][0]);
    json["accessors"][1]["sparse"] = {
        {"count", 1},
        {"indices", {{"bufferView", file.addView<uint8_t>({1})}, {"componentType", kUnsignedByte}}},
        {"values", {{"bufferView", file.addView<int8_t>({1, 2, 3})}}}};
    Json& primitives = json["meshes"][0]["primitives"];
    primitives[0]["mode"] = 5;
    primitives.push_back({{"attributes", {{"POSITION", 1}}}, {"mode", 6}});
    return file;
}

// Text, with its buffer beside it and in it.
std::string asText(GltfFile file, const std::string& uri) {
    file.json["buffers"] = Json::array({{{"byteLength", 36}, {"uri", uri}}});
    return file.json.dump();
}

}  // namespace

std::vector<std::pair<std::string, std::string>> sceneSeeds() {
    const std::vector<uint8_t> cornell = scenes::encodeGlb(scenes::cornellGlossy());
    return {{"sound.glb", sound().glb()},
            {"textured.glb", textured().glb()},
            {"transformed.glb", transformed().glb()},
            {"quantized.glb", quantized().glb()},
            {"cornell.glb", std::string(cornell.begin(), cornell.end())},
            {"beside.gltf", asText(oneTriangle(), "data.bin")},
            {"within.gltf", asText(oneTriangle(),
                                   "data:application/octet-stream;base64,"
                                   "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA")}};
}

}  // namespace sheen::fuzz
