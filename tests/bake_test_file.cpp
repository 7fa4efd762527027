// A scene's file with its lightmap: what was in it stays, and what is new is where it belongs.
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>

#include "bake/encode.h"
#include "scene/lightmap_file.h"
#include "scenes/all_scenes.h"
#include "test_bake.h"
#include "test_folder.h"

namespace sheen {
namespace {

struct Written {
    TestFolder folder;
    std::string in = (folder.path() / "in.glb").string();
    std::string out = (folder.path() / "out.glb").string();
    Scene before, after;
    LightmapFile file;

    explicit Written(bool unlit, bool lights_baked = false) {
        const std::vector<uint8_t> bytes = scenes::encodeGlb(scenes::cornellDiffuse());
        std::ofstream(in, std::ios::binary)
            .write(reinterpret_cast<const char*>(bytes.data()),
                   static_cast<std::streamsize>(bytes.size()));
        before = loadScene(in, {.sources = true});
        const Bench bench(before, 64);
        const Image<vec3> light(64, 64, vec3(0.5f, 1.0f, 2.0f));
        const EncodedLight encoded =
            unlit ? encodeUnlit(before, bench.map, light) : encodeIrradiance(bench.map, light);
        file = {.source = in,
                .corners = bench.map.atlas.corners,
                .png = encoded.png,
                .unlit = unlit,
                .intensity = encoded.intensity,
                .lights_baked = lights_baked};
        for (auto& corners : file.corners) {
            for (vec2& corner : corners) {
                corner /= 64.0f;
            }
        }
        writeLightmapped(out, before, file);
        after = loadScene(out);
    }
    nlohmann::json json() const {
        std::ifstream stream(out, std::ios::binary);
        std::string bytes((std::istreambuf_iterator<char>(stream)), {});
        uint32_t length = 0;
        std::memcpy(&length, bytes.data() + 12, 4);
        return nlohmann::json::parse(bytes.substr(20, length));
    }
};

TEST(LightmapFile, keepsTheSceneAndAddsCoordinates) {
    const Written w(false);
    ASSERT_EQ(w.after.triangles.size(), w.before.triangles.size());
    EXPECT_EQ(w.after.lights.size(), w.before.lights.size());
    EXPECT_EQ(w.after.cameras.size(), w.before.cameras.size());
    for (size_t i = 0; i < w.before.triangles.size(); ++i) {
        EXPECT_EQ(w.after.materials[w.after.materials_of[i]].name,
                  w.before.materials[w.before.materials_of[i]].name);
        for (int c = 0; c < 3; ++c) {
            const uint32_t old_vertex = w.before.triangles[i][c];
            const uint32_t new_vertex = w.after.triangles[i][c];
            EXPECT_EQ(w.after.positions[new_vertex], w.before.positions[old_vertex]);
            EXPECT_EQ(w.after.normals[new_vertex], w.before.normals[old_vertex]);
            EXPECT_EQ(w.after.second_uvs[new_vertex], w.file.corners[i][static_cast<size_t>(c)]);
        }
    }
}

TEST(LightmapFile, bakedAgainItTakesItsOwnCoordinates) {
    const Written w(false);
    std::string why;
    const Atlas atlas = atlasOfFile(w.after, {.size = 64}, why);
    EXPECT_EQ(why, "");
    EXPECT_TRUE(atlas.of_file);
}

TEST(LightmapFile, everyMaterialHasTheLightmap) {
    const nlohmann::json json = Written(false, true).json();
    const auto& used = json.at("extensionsUsed");
    EXPECT_NE(std::find(used.begin(), used.end(), "MOZ_lightmap"), used.end());
    EXPECT_EQ(std::find(used.begin(), used.end(), "KHR_lights_punctual"), used.end());
    for (const auto& mesh : json.at("meshes")) {
        for (const auto& primitive : mesh.at("primitives")) {
            const auto& material = json.at("materials").at(primitive.at("material").get<size_t>());
            const auto& lightmap = material.at("extensions").at("MOZ_lightmap");
            EXPECT_EQ(lightmap.at("texCoord"), 1);
            EXPECT_GT(lightmap.at("intensity").get<float>(), 1.9f);
            const auto& texture = json.at("textures").at(lightmap.at("index").get<size_t>());
            EXPECT_TRUE(
                json.at("images").at(texture.at("source").get<size_t>()).contains("bufferView"));
            const size_t accessor = primitive.at("attributes").at("TEXCOORD_1").get<size_t>();
            EXPECT_EQ(json.at("accessors").at(accessor).at("count"),
                      json.at("accessors")
                          .at(primitive.at("attributes").at("POSITION").get<size_t>())
                          .at("count"));
        }
    }
}

TEST(LightmapFile, unlitShowsLightTimesColour) {
    const Written w(true, true);
    EXPECT_TRUE(w.after.materials.front().unlit);
    EXPECT_EQ(w.after.triangles.size(), w.before.triangles.size());
}

// Where brightness is spread evenly, nothing is worth clipping.
TEST(EncodeIrradiance, clipsOnlyWhatIsWorthIt) {
    Scene scene;
    const uint32_t white = addMaterial(scene, diffuseParams(vec3(0.5f)));
    addQuad(scene, vec3(0), vec3(1, 0, 0), vec3(0, 0, -1), white);
    const Bench bench(scene, 64);
    Image<vec3> light(64, 64, vec3(1.0f));
    EXPECT_FLOAT_EQ(encodeIrradiance(bench.map, light).intensity, 1.0f);
    light.at(30, 30) = vec3(1.5f);
    EXPECT_FLOAT_EQ(encodeIrradiance(bench.map, light).intensity, 1.5f);
    EXPECT_FLOAT_EQ(encodeIrradiance(bench.map, Image<vec3>(64, 64)).intensity, 1.0f);
}

}  // namespace
}  // namespace sheen
