// Files that are valid in unusual ways, and files of which only the looks are broken: they load,
// and say what is missing.
#include <functional>

#include "scene_test_gltf.h"

namespace sheen {
namespace {

struct Blemish {
    const char* name;
    std::function<void(Json&)> apply;
    const char* warning;
};

void PrintTo(const Blemish& blemish, std::ostream* out) { *out << blemish.name; }

const Blemish kBlemishes[] = {
    {"TextureMissing",
     [](Json& j) { j["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["index"] = 3; },
     "texture 3"},
    {"TextureNegative",
     [](Json& j) { j["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["index"] = -3; },
     "texture -3"},
    {"TextureWithoutSource", [](Json& j) { j["textures"][0].erase("source"); }, "no image"},
    {"ImageMissing", [](Json& j) { j["textures"][0]["source"] = 8; }, "image 8"},
    {"ImageOfNothing",
     [](Json& j) {
         j["images"][0] = {{"name", "void"}};
     },
     "image 0 (void)"},
    {"ImageFileMissing",
     [](Json& j) {
         j["images"][0] = {{"uri", "no where.png"}};
     },
     "no where.png is not there"},
    {"ImageDataUriCutShort",
     [](Json& j) {
         j["images"][0] = {{"uri", "data:image/png"}};
     },
     "no comma"},
    {"ImageDataUriEmpty",
     [](Json& j) {
         j["images"][0] = {{"uri", "data:image/png;base64,"}};
     },
     "not base64"},
    {"ImageViewMissing", [](Json& j) { j["images"][0]["bufferView"] = 40; }, "buffer view 40"},
    {"ImageViewBeyondBuffer", [](Json& j) { j["bufferViews"][1]["byteOffset"] = 1 << 30; },
     "buffer view 1"},
    {"SamplerMissing", [](Json& j) { j["textures"][0]["sampler"] = 2; }, "sampler 2"},
    {"WrapUnknown", [](Json& j) { j["samplers"][0]["wrapS"] = 12; }, "wrap mode 12"},
    {"TransformMalformed",
     [](Json& j) {
         j["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["extensions"]
          ["KHR_texture_transform"]["scale"] = "large";
     },
     "scale"},
};

class SceneOptional : public testing::TestWithParam<Blemish> {};

TEST_P(SceneOptional, IsLeftOutAndSaid) {
    GltfFile file = textured();
    GetParam().apply(file.json);
    const Scene scene = file.load();
    EXPECT_EQ(scene.triangleCount(), 1);
    EXPECT_FALSE(scene.materials[0].textured());
    EXPECT_TRUE(warnsOf(scene, GetParam().warning)) << testing::PrintToString(scene.warnings);
}

INSTANTIATE_TEST_SUITE_P(Textures, SceneOptional, testing::ValuesIn(kBlemishes),
                         [](const auto& info) { return std::string(info.param.name); });

TEST(SceneOptionalParts, AnImageThatNoMaterialShowsIsNotAskedFor) {
    GltfFile file = oneTriangle();
    file.json["images"] = Json::array({{{"uri", "nowhere.png"}}, {{"uri", "data:oops"}}});
    file.json["textures"] = Json::array({{{"source", 0}}});
    EXPECT_FALSE(warnsOf(file.load(), "image"));
}

TEST(SceneOptionalParts, ABrokenAnimationIsIgnoredLikeAnyOther) {
    GltfFile file = oneTriangle();
    file.json["animations"] =
        Json::array({{{"samplers", Json::array({Json::object()})}, {"channels", 7}}});
    EXPECT_TRUE(warnsOf(file.load(), "the file is animated"));
}

TEST(SceneOptionalParts, RequiredExtensionsOfLooksAreIgnoredByName) {
    for (const char* name : {"KHR_materials_dispersion", "KHR_texture_basisu"}) {
        GltfFile file = oneTriangle();
        file.json["extensionsUsed"] = {name};
        file.json["extensionsRequired"] = {name};
        EXPECT_TRUE(warnsOf(file.load(), name));
    }
}

TEST(SceneOptionalParts, OfSeveralScenesTheDefaultIsShown) {
    GltfFile file = oneTriangle();
    file.json["nodes"].push_back({{"mesh", 0}, {"translation", {5, 0, 0}}});
    file.json["scenes"] = Json::array({{{"nodes", {0}}}, {{"nodes", {1}}}});
    EXPECT_EQ(file.load().bounds.lower.x, 0.0f);
    file.json["scene"] = 1;
    const Scene second = file.load();
    EXPECT_EQ(second.bounds.lower.x, 5.0f);
    EXPECT_EQ(second.triangleCount(), 1);
    EXPECT_TRUE(warnsOf(second, "2 scenes"));
}

TEST(SceneOptionalParts, PointsAndLinesAreOneNote) {
    GltfFile file = oneTriangle();
    Json& primitives = file.json["meshes"][0]["primitives"];
    for (int mode = 0; mode < 4; ++mode) {
        Json other = primitives[0];
        other["mode"] = mode;
        primitives.push_back(other);
    }
    const Scene scene = file.load();
    EXPECT_EQ(scene.triangleCount(), 1);
    EXPECT_EQ(std::count_if(scene.warnings.begin(), scene.warnings.end(),
                            [](const std::string& warning) {
                                return warning.find("points and lines") != std::string::npos;
                            }),
              1);
}

std::string base64(const std::string& bytes) {
    static const char* kDigits = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string text;
    for (size_t i = 0; i < bytes.size(); i += 3) {
        uint32_t word = 0;
        for (size_t k = 0; k < 3; ++k) {
            word = word << 8 | (i + k < bytes.size() ? static_cast<uint8_t>(bytes[i + k]) : 0u);
        }
        for (size_t k = 0; k < 4; ++k) {
            text += i + k <= bytes.size() ? kDigits[word >> (18 - 6 * k) & 63u] : '=';
        }
    }
    return text;
}

// The one triangle, as text, its buffer at a URI.
Scene withBufferAt(const std::string& uri) {
    GltfFile file = oneTriangle();
    file.json["buffers"] = Json::array({{{"byteLength", file.binary.size()}, {"uri", uri}}});
    const std::string path = temporaryPath("scene.gltf");
    writeFile(path, file.json.dump());
    return loadScene(path);
}

TEST(SceneBytes, DataUrisOfAnyMediaType) {
    const std::string bytes = oneTriangle().binary;
    for (const char* media : {"application/octet-stream", "application/gltf-buffer", "",
                              "application/bin", "model/gltf-buffer;charset=x"}) {
        const std::string uri = fmt::format("data:{};base64,{}", media, base64(bytes));
        EXPECT_EQ(withBufferAt(uri).triangleCount(), 1) << media;
    }
    std::string percents = "data:application/octet-stream,";
    for (const char byte : bytes) {
        percents += fmt::format("%{:02X}", static_cast<uint8_t>(byte));
    }
    EXPECT_EQ(withBufferAt(percents).triangleCount(), 1);
    EXPECT_THROW(withBufferAt("data:;base64,AAAA"), Error) << "shorter than byteLength";
}

TEST(SceneBytes, ABufferMayBeLongerThanItMustBe) {
    const std::string bytes = oneTriangle().binary + "and more";
    EXPECT_EQ(withBufferAt("data:;base64," + base64(bytes)).triangleCount(), 1);
    writeFile(temporaryPath("a file.bin"), bytes);
    EXPECT_EQ(withBufferAt("a%20file.bin").triangleCount(), 1);
}

TEST(SceneBytes, ABufferThatNothingReadsMayBeMissing) {
    GltfFile file = oneTriangle();
    file.json["buffers"] = Json::array({{{"byteLength", file.binary.size()}},
                                        {{"byteLength", 1 << 20}},
                                        {{"byteLength", 8}, {"uri", "nowhere.bin"}}});
    EXPECT_EQ(file.load().triangleCount(), 1);
}

TEST(SceneBytes, AnAccessorWithoutAViewIsZeros) {
    GltfFile file = oneTriangle();
    Json zeros = file.json["accessors"][0];
    zeros.erase("bufferView");
    file.json["accessors"].push_back(zeros);
    file.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] = 1;
    const Scene normals = file.load();
    EXPECT_EQ(normals.normals[0], vec3(0, 0, 1));
    EXPECT_TRUE(warnsOf(normals, "normal that was zero"));

    // Indices 0 0 0, of which a sparse part makes 0 1 2.
    const int indices = file.addView<uint8_t>({1, 2});
    file.json["accessors"].push_back(
        {{"componentType", kUnsignedByte},
         {"count", 3},
         {"type", "SCALAR"},
         {"sparse",
          {{"count", 2},
           {"indices", {{"bufferView", indices}, {"componentType", kUnsignedByte}}},
           {"values", {{"bufferView", indices}}}}}});
    file.json["meshes"][0]["primitives"][0]["indices"] = 2;
    EXPECT_EQ(file.load().triangleCount(), 1);
}

}  // namespace
}  // namespace sheen
