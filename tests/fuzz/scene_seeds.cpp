// Small scenes that use everything the loader reads, mends or leaves out.
#include <tiny_gltf.h>

#include <limits>

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
GltfFile painted() {
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

// Everything that varies over a surface.
GltfFile varied() {
    GltfFile file = painted();
    Json& json = file.json;
    Json& attributes = json["meshes"][0]["primitives"][0]["attributes"];
    attributes["TEXCOORD_1"] = file.addAccessor<float>({0, 0, 1, 0, 0, 1}, kFloat, "VEC2", 2);
    attributes["COLOR_0"] = file.addAccessor<float>({1, 0, 0, 0, 1, 0, 0, 0, 1}, kFloat, "VEC3", 3);
    attributes["TANGENT"] =
        file.addAccessor<float>({1, 0, 0, 1, 1, 0, 0, 1, 1, 0, 0, -1}, kFloat, "VEC4", 4);
    json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["TRANSLATION"] =
        file.addAccessor<float>({1, 0, 0, 0, 1, 0}, kFloat, "VEC3", 3);
    json["samplers"][0] = {{"magFilter", 9728}, {"wrapS", 33071}, {"wrapT", 33648}};
    Json& material = json["materials"][0];
    material["normalTexture"] = {{"index", 0}, {"scale", 0.5}};
    material["alphaMode"] = "MASK";
    material["emissiveFactor"] = {1, 1, 1};
    material["emissiveTexture"] = {{"index", 0}, {"texCoord", 1}};
    material["pbrMetallicRoughness"]["metallicRoughnessTexture"]["index"] = 1;
    material["pbrMetallicRoughness"]["baseColorTexture"]["extensions"]["KHR_texture_transform"] = {
        {"offset", {0.5, 0.25}}, {"rotation", 0.7}, {"scale", {2, 3}}, {"texCoord", 1}};
    material["extensions"]["KHR_materials_specular"] = {{"specularTexture", {{"index", 0}}},
                                                        {"specularColorTexture", {{"index", 1}}}};
    material["extensions"]["KHR_materials_transmission"] = {
        {"transmissionFactor", 0.5}, {"transmissionTexture", {{"index", 1}}}};
    material["extensions"]["KHR_materials_volume"] = {{"thicknessFactor", 1},
                                                      {"attenuationDistance", 0.5},
                                                      {"attenuationColor", {0.5, 0.7, 0.9}}};
    material["extensions"]["KHR_materials_iridescence"] = {
        {"iridescenceFactor", 0.5},
        {"iridescenceTexture", {{"index", 0}}},
        {"iridescenceThicknessTexture", {{"index", 1}}}};
    material["extensions"]["KHR_materials_clearcoat"] = {
        {"clearcoatFactor", 0.5}, {"clearcoatNormalTexture", {{"index", 0}, {"scale", 0.5}}}};
    json["materials"][1]["extensions"]["KHR_materials_unlit"] = Json::object();
    json["extensionsUsed"] = {"KHR_texture_transform", "KHR_materials_unlit",
                              "EXT_mesh_gpu_instancing"};
    return file;
}

// One of everything that is noted and left out, or mended.
GltfFile leftOut() {
    GltfFile file = painted();
    Json& json = file.json;
    json["images"].push_back(
        {{"uri",
          "data:image/png;base64,iVBORw0KGgoAAAANSUhEUgAAAAEAAAABEAIAAADA54+dAAAA"
          "D0lEQVR4nGP4/7+BgYERAAz9AoCMYRPtAAAAAElFTkSuQmCC"}});  // 16 bits
    json["textures"].push_back({{"source", 2}});
    json["samplers"][0] = {{"magFilter", 9728}, {"wrapS", 33071}, {"wrapT", 33648}};
    Json& material = json["materials"][0];
    for (const char* texture : {"normalTexture", "occlusionTexture", "emissiveTexture"}) {
        material[texture]["index"] = 0;
    }
    material["pbrMetallicRoughness"]["metallicRoughnessTexture"]["index"] = 2;
    material["pbrMetallicRoughness"]["baseColorTexture"]["texCoord"] = 2;
    material["pbrMetallicRoughness"]["baseColorTexture"]["extensions"]["KHR_texture_transform"] =
        Json::object();
    material["alphaMode"] = "BLEND";
    json["materials"][1]["pbrMetallicRoughness"]["baseColorTexture"]["index"] = 2;
    json["materials"][1]["extensions"]["KHR_materials_specular"]["specularTexture"]["index"] = 0;
    json["meshes"][0]["primitives"].push_back({{"attributes", {{"POSITION", 0}}}, {"mode", 1}});
    Json& primitive = json["meshes"][0]["primitives"][0];
    primitive["targets"] = Json::array({{{"POSITION", 0}}});
    json["nodes"][0]["skin"] = 0;
    json["nodes"][0]["matrix"] = {2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2, 0, 0, 0, 0, 2};
    json["cameras"].push_back(
        {{"type", "orthographic"},
         {"orthographic", {{"xmag", 1}, {"ymag", 1}, {"znear", 0.1}, {"zfar", 9}}}});
    json["nodes"].push_back({{"camera", 1}});
    json["nodes"].push_back({{"camera", 0}, {"scale", {0, 0, 0}}});
    json["extensionsUsed"] = {"KHR_materials_clearcoat"};
    json["animations"] = Json::array({{{"channels", Json::array()}, {"samplers", Json::array()}}});
    json["extensions"]["KHR_lights_punctual"]["lights"][0] = {
        {"type", "spot"},
        {"color", {1.0, -0.5, 0.2}},
        {"spot", {{"innerConeAngle", 0.3}, {"outerConeAngle", 0.3}}}};
    json["extensions"]["KHR_lights_punctual"]["lights"].push_back({{"type", "directional"}});
    json["nodes"].push_back(
        {{"scale", {0, 0, 0}}, {"extensions", {{"KHR_lights_punctual", {{"light", 1}}}}}});
    return file;
}

// A sky of its own.
GltfFile underASky() {
    GltfFile file = painted();
    Json& json = file.json;
    json["extensionsUsed"] = {"EXT_lights_image_based"};
    json["extensions"]["EXT_lights_image_based"]["lights"] =
        Json::array({{{"intensity", 2},
                      {"rotation", {0, 0.6, 0, 0.8}},
                      {"specularImageSize", 1},
                      {"specularImages", Json::array({{1, 1, 1, 1, 1, 1}})}}});
    Json nodes = Json::array();
    for (size_t i = 0; i < json["nodes"].size(); ++i) {
        nodes.push_back(i);
    }
    json["scenes"] = Json::array(
        {{{"nodes", nodes}, {"extensions", {{"EXT_lights_image_based", {{"light", 0}}}}}}});
    return file;
}

// Triangles of two materials in one plane, one of them upright in three planes.
GltfFile coplanar() {
    GltfFile file;
    file.json["materials"] = Json::array({{{"name", "a"}},
                                          {{"name", "b"},
                                           {"alphaMode", "OPAQUE"},
                                           {"pbrMetallicRoughness", {{"roughnessFactor", 0.5}}}}});
    file.addPrimitive({0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1})["material"] = 0;
    file.addPrimitive({0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0, 0, 1, 0, 0, 0, 1})["material"] = 1;
    file.addPrimitive({0, 1, 0, 1, 0, 0, 1, 1, 0})["material"] = 1;
    return file;
}

// Integers of every size, normalised and not; zero normals, corners that coincide or are nowhere.
GltfFile components() {
    GltfFile file = sound();
    Json& json = file.json;
    json["extensionsUsed"] = {"KHR_mesh_quantization"};
    Json& primitives = json["meshes"][0]["primitives"];
    const auto accessor = [&](const auto& values, int type, const char* shape, int count,
                              bool normalized) {
        const int index = file.addAccessor(values, type, shape, count);
        json["accessors"].back()["normalized"] = normalized;
        return index;
    };
    constexpr int kShort = 5122;
    primitives[0]["attributes"]["TEXCOORD_0"] =
        accessor(std::vector<uint16_t>{0, 0, 65535, 0, 0, 65535}, kUnsignedShort, "VEC2", 2, true);
    primitives[0]["indices"] =
        accessor(std::vector<uint32_t>{0, 1, 2}, kUnsignedInt, "SCALAR", 1, false);
    const int shorts = accessor(std::vector<int16_t>{0, 0, 0, 9, 0, 0, 0, 9, 0, 0, 0, 0}, kShort,
                                "VEC3", 3, false);
    const int bytes = accessor(std::vector<int8_t>{0, 0, 127, 0, 127, 0, 0, 0, 0, 0, 0, -128},
                               kByte, "VEC3", 3, true);
    const int shares =
        accessor(std::vector<uint8_t>{0, 0, 255, 0, 0, 255, 9, 9}, kUnsignedByte, "VEC2", 2, true);
    json["bufferViews"][json["accessors"][shorts]["bufferView"].get<int>()]["byteLength"] = 24;
    json["accessors"][shorts]["count"] = 4;
    primitives.push_back(
        {{"attributes", {{"POSITION", shorts}, {"NORMAL", bytes}, {"TEXCOORD_0", shares}}},
         {"indices", accessor(std::vector<uint8_t>{0, 1, 2, 1, 2, 3, 0, 3, 1}, kUnsignedByte,
                              "SCALAR", 1, false)}});
    constexpr float kNowhere = std::numeric_limits<float>::quiet_NaN();
    file.addPrimitive(
        {0, 0, 0, 1, 0, 0, 2, 0, 0, 0, 0, 0, 1, 0, kNowhere, 0, 1, 0, 0, 0, 1, 1, 0, 1, 0, 1, 1});
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
            {"textured.glb", painted().glb()},
            {"varied.glb", varied().glb()},
            {"transformed.glb", transformed().glb()},
            {"quantized.glb", quantized().glb()},
            {"left_out.glb", leftOut().glb()},
            {"under_a_sky.glb", underASky().glb()},
            {"coplanar.glb", coplanar().glb()},
            {"components.glb", components().glb()},
            {"cornell.glb", std::string(cornell.begin(), cornell.end())},
            {"beside.gltf", asText(oneTriangle(), "data.bin")},
            {"within.gltf", asText(oneTriangle(),
                                   "data:application/octet-stream;base64,"
                                   "AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA")}};
}

}  // namespace sheen::fuzz
