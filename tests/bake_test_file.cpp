// A scene's file with its lightmap: what was in it stays, and what is new is where it belongs.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>

#include "bake/encode.h"
#include "image/decode.h"
#include "scene/lightmap_file.h"
#include "scenes/all_scenes.h"
#include "test_bake.h"
#include "test_folder.h"
#include "test_glb.h"

namespace sheen {
namespace {

struct Written {
    TestFolder folder;
    std::string in = (folder.path() / "in.glb").string();
    std::string out = (folder.path() / "out.glb").string();
    Scene before, after;
    LightmapFile file;

    explicit Written(
        bool unlit, bool lights_baked = false, const Edit& edit = [](Json&) {}) {
        const std::vector<uint8_t> bytes = scenes::encodeGlb(scenes::cornellDiffuse());
        std::ofstream(in, std::ios::binary)
            << edited(std::string(bytes.begin(), bytes.end()), edit);
        before = loadScene(in, {.environment = {.source = "1,1,1"}, .sources = true});
        const Bench bench(before, 64);
        const Image<vec3> light(64, 64, vec3(0.5f, 1.0f, 2.0f));
        const EncodedLight encoded =
            unlit ? encodeUnlit(before, bench.map, light) : encodeIrradiance(bench.map, light);
        file = lightmapFileOf(in, bench.map.atlas);
        file.pngs = encoded.pngs;
        file.unlit = unlit;
        file.intensity = encoded.intensity;
        file.lights_baked = lights_baked;
        writeLightmapped(out, before, file);
        after = loadScene(out);
    }
    Json json() const {
        std::ifstream stream(out, std::ios::binary);
        return jsonOf(std::string((std::istreambuf_iterator<char>(stream)), {}));
    }
};

// What is said of a file that cannot be taken over.
std::string refusal(const Edit& edit) {
    try {
        Written(false, false, edit);
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ExitCode::kInput);
        return error.what();
    }
    return "nothing";
}
Json& firstPrimitive(Json& json) { return json["meshes"][0]["primitives"][0]; }

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
    const Json json = Written(false, true).json();
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

// Light that the lightmap has must not be in the file again.
TEST(LightmapFile, dropsTheFilesOwnSky) {
    const Json json = Written(false, false, [](Json& scene) {
                          const char* name = "EXT_lights_image_based";
                          scene["extensionsUsed"].push_back(name);
                          scene["extensions"][name]["lights"] = Json::array({Json::object()});
                          scene["scenes"][0]["extensions"][name]["light"] = 0;
                      }).json();
    EXPECT_EQ(json.dump().find("EXT_lights_image_based"), std::string::npos);
    EXPECT_NE(json.dump().find("KHR_lights_punctual"), std::string::npos);
}

// Textures that Sheen knows nothing of keep their coordinates, and sets have no gaps.
TEST(LightmapFile, takesTheNextSetWhereAnyTextureUsesTheSecond) {
    const Json json =
        Written(false, false, [](Json& scene) {
            scene["materials"][0]["extensions"]["KHR_materials_diffuse_transmission"] = {
                {"diffuseTransmissionTexture", {{"index", 0}, {"texCoord", 1}}}};
            Json& attributes = firstPrimitive(scene)["attributes"];
            Json accessor = scene["accessors"][attributes["POSITION"].get<size_t>()];
            accessor["type"] = "VEC2";
            accessor.erase("min");
            accessor.erase("max");
            attributes["TEXCOORD_1"] = scene["accessors"].size();
            scene["accessors"].push_back(accessor);
        }).json();
    for (const auto& mesh : json.at("meshes")) {
        for (const auto& primitive : mesh.at("primitives")) {
            for (const char* name : {"TEXCOORD_0", "TEXCOORD_1", "TEXCOORD_2"}) {
                EXPECT_TRUE(primitive.at("attributes").contains(name)) << name;
            }
            const auto& material = json.at("materials").at(primitive.at("material").get<size_t>());
            EXPECT_EQ(material.at("extensions").at("MOZ_lightmap").at("texCoord"), 2);
        }
    }
}

TEST(LightmapFile, unlitMaterialsGetNone) {
    const Json json = Written(false, false, [](Json& scene) {
                          scene["materials"][0]["extensions"]["KHR_materials_unlit"] =
                              Json::object();
                      }).json();
    EXPECT_FALSE(json.at("materials").at(0).at("extensions").contains("MOZ_lightmap"));
    EXPECT_TRUE(json.at("materials").at(1).at("extensions").contains("MOZ_lightmap"));
}

TEST(LightmapFile, refusesWhatIsMalformedWhereTheLoaderDoesNotLook) {
    const auto gathered = [](const char* name, int component_type, const Edit& more) {
        return refusal([&](Json& scene) {
            Json accessor =
                scene["accessors"][firstPrimitive(scene)["attributes"]["POSITION"].get<size_t>()];
            accessor["count"] = 1;
            accessor["componentType"] = component_type;
            firstPrimitive(scene)["attributes"][name] = scene["accessors"].size();
            scene["accessors"].push_back(accessor);
            more(scene);
        });
    };
    constexpr int kFloat = 5126, kDouble = 5130;
    const auto nothing = [](Json&) {};
    for (const char* name : {"TEXCOORD_2", "COLOR_1", "_CUSTOM"}) {
        const std::string said = gathered(name, kFloat, nothing);
        EXPECT_NE(said.find("has 1 elements"), std::string::npos) << said;
    }
    const std::string said = gathered("_CUSTOM", kDouble, nothing);
    EXPECT_NE(said.find("componentType 5130"), std::string::npos) << said;
    for (const Json& target :
         {Json{{"POSITION", "x"}}, Json{{"POSITION", 1e9}}, Json{{"POSITION", -1}}, Json("x")}) {
        const std::string of_target =
            refusal([&](Json& scene) { firstPrimitive(scene)["targets"] = Json::array({target}); });
        EXPECT_NE(of_target.find("export"), std::string::npos) << target << of_target;
    }
}

// Many views of the same bytes would be as many copies.
TEST(LightmapFile, refusesViewsThatTogetherAreTooLarge) {
    const std::string said = refusal([](Json& scene) {
        constexpr size_t kSize = 1 << 20, kDigits = 1398102;
        scene["buffers"].push_back(
            {{"byteLength", kSize},
             {"uri", "data:application/octet-stream;base64," + std::string(kDigits, 'A') + "=="}});
        for (int i = 0; i < 4100; ++i) {
            scene["bufferViews"].push_back({{"buffer", 1}, {"byteLength", kSize}});
        }
    });
    EXPECT_NE(said.find("more than 4 GiB"), std::string::npos) << said;
}

// A coat reflects of white light what the surface below does not get of it, and more where that is
// dark.
TEST(EncodeUnlit, coatsAndAlphaAreInIt) {
    Scene scene;
    const uint32_t dark = addMaterial(scene, diffuseParams(vec3(0.0f)));
    addQuad(scene, vec3(0), vec3(1, 0, 0), vec3(0, 0, -1), dark);
    const auto decoded = [&] {
        const Bench bench(scene, 16);
        const std::string png =
            encodeUnlit(scene, bench.map, Image<vec3>(16, 16, vec3(kPi))).pngs.front();
        return decodeImage({reinterpret_cast<const uint8_t*>(png.data()), png.size()});
    };
    const DecodedImage bare = decoded();
    scene.materials[dark].layers.coat = 1.0f;
    const DecodedImage coated = decoded();
    EXPECT_GT(coated.rgba[4 * 8 * 17], bare.rgba[4 * 8 * 17]);
    // Around charts too.
    scene.materials[dark].alpha = 0.5f;
    scene.materials[dark].blended = true;
    const DecodedImage half = decoded();
    for (size_t i = 0; i < half.rgba.size(); i += 4) {
        EXPECT_NEAR(half.rgba[i + 3] / 65535.0, 0.5, 0.01);
    }
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
