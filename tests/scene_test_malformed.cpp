// The loader on files that are broken: always one line that names the file, never a crash.
#include <algorithm>
#include <functional>

#include "scene_test_gltf.h"

namespace sheen {
namespace {

void expectInputError(const std::string& path, const std::string& mentions) {
    try {
        loadScene(path);
        ADD_FAILURE() << "loaded; expected an error about " << mentions;
    } catch (const Error& error) {
        const std::string message = error.what();
        EXPECT_EQ(error.code(), ExitCode::kInput) << message;
        EXPECT_EQ(message.rfind(path, 0), 0u) << "must begin with the file: " << message;
        EXPECT_NE(message.find(mentions), std::string::npos) << message;
        EXPECT_TRUE(std::none_of(message.begin(), message.end(), [](unsigned char c) {
            return c < 0x20 || c == 0x7f;
        })) << message;
    }
}

struct Breakage {
    const char* name;
    std::function<void(Json&)> apply;
    const char* mentions;
};

void PrintTo(const Breakage& breakage, std::ostream* out) { *out << breakage.name; }

Json& primitiveOf(Json& json) { return json["meshes"][0]["primitives"][0]; }
void useTexture(Json& json, int index) {
    json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"]["index"] = index;
}

const Breakage kBreakages[] = {
    {"PositionAccessorMissing", [](Json& j) { primitiveOf(j)["attributes"]["POSITION"] = 99; },
     "accessor 99"},
    {"PositionAccessorNegative", [](Json& j) { primitiveOf(j)["attributes"]["POSITION"] = -3; },
     "accessor -3"},
    {"IndexAccessorMissing", [](Json& j) { primitiveOf(j)["indices"] = 99; }, "indices"},
    {"IndexAccessorNegative", [](Json& j) { primitiveOf(j)["indices"] = -7; }, "accessor -7"},
    {"IndexOutOfRange",
     [](Json& j) {
         j["accessors"][1]["bufferView"] = 0;
         j["accessors"][1]["byteOffset"] = 12;  // the bits of the position 1.0
     },
     "out of range"},
    {"IndicesAreFloats", [](Json& j) { primitiveOf(j)["indices"] = 0; }, "unsigned integer"},
    {"MaterialMissing", [](Json& j) { primitiveOf(j)["material"] = 5; }, "material 5"},
    {"MaterialNegative", [](Json& j) { primitiveOf(j)["material"] = -5; }, "material -5"},
    {"ModeUnknown", [](Json& j) { primitiveOf(j)["mode"] = 17; }, "mode 17"},
    {"BufferViewMissing", [](Json& j) { j["accessors"][0]["bufferView"] = 99; }, "buffer view 99"},
    {"AccessorBeyondView", [](Json& j) { j["accessors"][0]["count"] = 4; }, "reach beyond"},
    {"AccessorCountHuge", [](Json& j) { j["accessors"][0]["count"] = 18446744073709551615ull; },
     "reach beyond"},
    {"AccessorCountZero", [](Json& j) { j["accessors"][0]["count"] = 0; }, "no elements"},
    {"AccessorOffsetHuge",
     [](Json& j) { j["accessors"][0]["byteOffset"] = 18446744073709551608ull; }, "reach beyond"},
    {"AccessorTypeUnknown", [](Json& j) { j["accessors"][0]["type"] = "VEC5"; }, "VEC5"},
    {"AccessorComponentUnknown", [](Json& j) { j["accessors"][0]["componentType"] = 7; }, "7"},
    {"PositionsAreBytes", [](Json& j) { j["accessors"][0]["componentType"] = kByte; }, "byte"},
    {"PositionsAreDoubles", [](Json& j) { j["accessors"][0]["componentType"] = 5130; },
     "components"},
    {"PositionsAreVec2", [](Json& j) { j["accessors"][0]["type"] = "VEC2"; }, "VEC3"},
    {"NormalsAreFewer", [](Json& j) { j["accessors"][2]["count"] = 2; }, "NORMAL"},
    {"TexcoordsAreFewer", [](Json& j) { j["accessors"][3]["count"] = 1; }, "TEXCOORD_0"},
    {"StrideUneven", [](Json& j) { j["bufferViews"][0]["byteStride"] = 13; }, "byteStride"},
    {"StrideTooLong", [](Json& j) { j["bufferViews"][0]["byteStride"] = 252; }, "reach beyond"},
    {"ViewBeyondBuffer", [](Json& j) { j["bufferViews"][0]["byteLength"] = 100000; },
     "buffer view 0"},
    {"ViewOffsetHuge", [](Json& j) { j["bufferViews"][0]["byteOffset"] = 18446744073709551615ull; },
     "buffer view 0"},
    {"ViewOfMissingBuffer", [](Json& j) { j["bufferViews"][0]["buffer"] = 4; }, "buffer 4"},
    {"BufferLongerThanFile",
     [](Json& j) {
         j["buffers"] = Json::array({{{"byteLength", 1 << 20}}});
     },
     "byteLength"},
    {"BufferOfNoBytes",
     [](Json& j) {
         j["buffers"] = Json::array({{{"byteLength", 0}}});
     },
     "0 bytes of buffer 0"},
    {"BufferFileMissing",
     [](Json& j) {
         j["buffers"] = Json::array({{{"byteLength", 8}, {"uri", "nowhere.bin"}}});
     },
     "nowhere.bin"},
    {"BufferFileIsADevice",
     [](Json& j) {
         j["buffers"] =
             Json::array({{{"byteLength", 8}, {"uri", "../../../../../../../../dev/zero"}}});
     },
     "dev/zero is not a file"},
    {"SparseIndexOutOfRange",
     [](Json& j) {
         j["accessors"][0]["sparse"] = {
             {"count", 1},
             {"indices", {{"bufferView", 2}, {"componentType", kUnsignedInt}, {"byteOffset", 8}}},
             {"values", {{"bufferView", 2}}}};
     },
     "sparse"},
    {"SparseCountNegative",
     [](Json& j) {
         j["accessors"][0]["sparse"] = {
             {"count", -1},
             {"indices", {{"bufferView", 1}, {"componentType", kUnsignedShort}}},
             {"values", {{"bufferView", 0}}}};
     },
     "sparse"},
    {"SpecularFactorIsText",
     [](Json& j) {
         j["materials"][0]["extensions"]["KHR_materials_specular"]["specularFactor"] = "much";
     },
     "specularFactor"},
    {"SpecularColorTooShort",
     [](Json& j) {
         j["materials"][0]["extensions"]["KHR_materials_specular"]["specularColorFactor"] = {1, 2};
     },
     "specularColorFactor"},
    {"EmissionOverflows",
     [](Json& j) {
         j["materials"][0]["emissiveFactor"] = {1, 1, 1};
         j["materials"][0]["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"] =
             1e300;
     },
     "emission"},
    {"MeshMissing", [](Json& j) { j["nodes"][0]["mesh"] = 4; }, "mesh 4"},
    {"CameraMissing", [](Json& j) { j["nodes"][1]["camera"] = 4; }, "camera 4"},
    {"LightMissing",
     [](Json& j) { j["nodes"][2]["extensions"]["KHR_lights_punctual"]["light"] = 4; }, "light 4"},
    {"LightIndexHuge",
     [](Json& j) { j["nodes"][2]["extensions"]["KHR_lights_punctual"]["light"] = 1e18; }, "light"},
    {"LightTypeUnknown",
     [](Json& j) { j["extensions"]["KHR_lights_punctual"]["lights"][0]["type"] = "candle"; },
     "candle"},
    {"LightNegative",
     [](Json& j) { j["extensions"]["KHR_lights_punctual"]["lights"][0]["intensity"] = -1; },
     "negative"},
    {"ConeInsideOut",
     [](Json& j) {
         j["extensions"]["KHR_lights_punctual"]["lights"][0] = {
             {"type", "spot"}, {"spot", {{"innerConeAngle", 0.9}, {"outerConeAngle", 0.3}}}};
     },
     "cone"},
    {"FieldOfViewTooWide", [](Json& j) { j["cameras"][0]["perspective"]["yfov"] = 4.0; }, "yfov"},
    {"ChildMissing", [](Json& j) { j["nodes"][1]["children"] = {9}; }, "node 9"},
    {"NodeCycle",
     [](Json& j) {
         j["nodes"][1]["children"] = {2};
         j["nodes"][2]["children"] = {1};
         j["scenes"] = Json::array({{{"nodes", {1}}}});
     },
     "reached twice"},
    {"NodeIsItsOwnChild",
     [](Json& j) {
         j["nodes"][1]["children"] = {1};
         j["scenes"] = Json::array({{{"nodes", {1}}}});
     },
     "reached twice"},
    {"SceneMissing",
     [](Json& j) {
         j["scenes"] = Json::array({{{"nodes", {0}}}});
         j["scene"] = 3;
     },
     "scene 3"},
    {"MatrixTooShort",
     [](Json& j) {
         j["nodes"][0]["matrix"] = {1, 0, 0};
     },
     "matrix"},
    {"RotationZero",
     [](Json& j) {
         j["nodes"][0]["rotation"] = {0, 0, 0, 0};
     },
     "rotation"},
    {"ScaleOverflows",
     [](Json& j) {
         j["nodes"][0]["scale"] = {1e300, 1, 1};
     },
     "scale"},
    {"TransformsOverflowTogether",
     [](Json& j) {
         j["nodes"][0]["scale"] = {1e30, 1, 1};
         j["nodes"][1]["scale"] = {1e30, 1, 1};
         j["nodes"][1]["children"] = {0};
     },
     "transform"},
    {"NodeBeyondSquaresOfFloats",
     [](Json& j) {
         j["nodes"][0]["translation"] = {0, 2e18, 0};
     },
     "from the origin"},
    {"MeshBeyondSquaresOfFloats",
     [](Json& j) {
         j["nodes"][0]["scale"] = {1e19, 1e-9, 1e-9};
     },
     "from the origin"},
    {"MeshesTooFarApart",
     [](Json& j) {
         j["nodes"][0]["translation"] = {0, 0, 9e17};
         j["nodes"].push_back({{"mesh", 0}, {"translation", {0, 0, -9e17}}});
     },
     "extend over"},
    {"FieldOfViewRoundsToPi", [](Json& j) { j["cameras"][0]["perspective"]["yfov"] = 3.14159265; },
     "yfov"},
    {"FieldOfViewRoundsToZero", [](Json& j) { j["cameras"][0]["perspective"]["yfov"] = 1e-300; },
     "yfov"},
    {"NodeNameIsAnyText",
     [](Json& j) {
         j["nodes"][0]["name"] = "lamp\n\x1b[31m\x7f" + std::string(100000, 'x');
         j["nodes"][0]["mesh"] = 9;
     },
     "mesh 9"},
    {"AccessorTypeIsAnEscapeSequence", [](Json& j) { j["accessors"][0]["type"] = "\x1b[m"; },
     "type"},
    {"RequiredExtensionUnknown", [](Json& j) { j["extensionsRequired"] = {"KHR_secret"}; },
     "KHR_secret"},
    {"DracoOfNoMesh",
     [](Json& j) {
         primitiveOf(j)["extensions"]["KHR_draco_mesh_compression"] = {{"bufferView", 0}};
         j["accessors"][0].erase("bufferView");
     },
     "KHR_draco_mesh_compression"},
    {"VersionOne", [](Json& j) { j["asset"]["version"] = "1.0"; }, "version"},
    {"AssetMissing", [](Json& j) { j.erase("asset"); }, "asset"},
    {"MeshesAreNumbers",
     [](Json& j) {
         j["meshes"] = {1, 2};
     },
     "glTF"},
};

class SceneLoaderMalformed : public testing::TestWithParam<Breakage> {};

TEST_P(SceneLoaderMalformed, IsOneLineOfInputError) {
    GltfFile file = sound();
    GetParam().apply(file.json);
    expectInputError(file.write(), GetParam().mentions);
}

INSTANTIATE_TEST_SUITE_P(Json, SceneLoaderMalformed, testing::ValuesIn(kBreakages),
                         [](const auto& info) { return std::string(info.param.name); });

// The sound file with an image of these bytes on its material.
GltfFile withImage(const std::vector<uint8_t>& bytes) {
    GltfFile file = sound();
    file.json["images"][0]["bufferView"] = file.addView(bytes);
    useTexture(file.json, 0);
    return file;
}

// Only looks suffer: the material is shown without it, and the file's user told.
void expectLeftOut(const GltfFile& file, const std::string& part) {
    const Scene scene = file.load();
    EXPECT_FALSE(scene.materials[0].textured());
    EXPECT_TRUE(warnsOf(scene, part)) << part;
}

TEST(SceneLoaderBroken, ImageThatIsNotThere) {
    GltfFile file = sound();
    useTexture(file.json, 0);
    file.json["images"][0] = {{"uri", "nowhere.png"}};
    expectLeftOut(file, "nowhere.png");
    file.json["textures"][0].erase("source");
    expectLeftOut(file, "texture 0 has no image");
}

TEST(SceneLoaderBroken, ImageOfAFormatThatGltfHasNot) {
    const std::vector<uint8_t> gif = {'G', 'I', 'F', '8', '9', 'a', 1, 0, 1, 0, 0, 0, 0, 0x2c, 0,
                                      0,   0,   0,   1,   0,   1,   0, 0, 2, 2, 4, 1, 0, 0x3b};
    expectLeftOut(withImage(gif), "neither PNG, JPEG nor WebP");
}

// 57 bytes that ask for 300 MB.
TEST(SceneLoaderBroken, ImageThatPromisesMoreTexelsThanItCanHold) {
    const std::vector<uint8_t> png = {
        0x89, 'P',  'N',  'G',  '\r', '\n', 0x1a, '\n', 0,    0,   0,   13, 'I', 'H', 'D',
        'R',  0,    0,    0x27, 0x10, 0,    0,    0x27, 0x10, 8,   2,   0,  0,   0,   0x35,
        0x2c, 0xf5, 0x70, 0,    0,    0,    0,    'I',  'D',  'A', 'T', 0,  0,   0,   0,
        0,    0,    0,    0,    'I',  'E',  'N',  'D',  0,    0,   0,   0};
    expectLeftOut(withImage(png), "10000 x 10000 texels it promises");
}

// After a comment that looks like a table, a table of 17 symbols and one of 16 times 17.
TEST(SceneLoaderBroken, JpegWithAHuffmanTableTooLong) {
    std::vector<uint8_t> jpeg = {0xff, 0xd8, 0xff, 0xfe, 0, 6, 0xff, 0xc4, 0xff, 0xff};
    const auto addTable = [&](uint8_t codes, int lengths) {
        const int symbols = codes * lengths;
        const int length = 2 + 1 + 16 + symbols;
        jpeg.insert(jpeg.end(), {0xff, 0xc4, static_cast<uint8_t>(length >> 8),
                                 static_cast<uint8_t>(length & 0xff), 0});
        for (int i = 0; i < 16; ++i) {
            jpeg.push_back(i < lengths ? codes : uint8_t{0});
        }
        jpeg.insert(jpeg.end(), static_cast<size_t>(symbols), 1);
    };
    addTable(17, 1);
    expectLeftOut(withImage(jpeg), "cannot be decoded");
    addTable(17, 16);
    expectLeftOut(withImage(jpeg), "cannot be decoded");
}

TEST(SceneLoaderBroken, NamesBecomeOneLine) {
    GltfFile file = sound();
    file.json["cameras"][0]["name"] = "left\n\teye\x1b";
    file.json["materials"][0]["name"] = "paint\r";
    const Scene scene = file.load();
    EXPECT_EQ(scene.cameras[0].name, "left  eye");
    EXPECT_EQ(scene.materials[0].name, "paint");
}

TEST(SceneLoaderBroken, TheSoundFileLoads) { EXPECT_EQ(sound().load().triangleCount(), 1); }

TEST(SceneLoaderBroken, MissingFile) {
    expectInputError(temporaryPath("absent.glb"), "no such file");
}

TEST(SceneLoaderBroken, Directory) {
    const std::string path = temporaryPath("folder.glb");
    std::filesystem::create_directories(path);
    expectInputError(path, "directory");
}

TEST(SceneLoaderBroken, EmptyFile) {
    const std::string path = temporaryPath("empty.glb");
    writeFile(path, "");
    expectInputError(path, "empty");
}

TEST(SceneLoaderBroken, TextRenamed) {
    const std::string path = temporaryPath("notes.glb");
    writeFile(path, "Dear diary, today I rendered a teapot.\n");
    expectInputError(path, "neither");
}

TEST(SceneLoaderBroken, JsonCutShort) {
    const std::string path = temporaryPath("cut.gltf");
    writeFile(path, R"({"asset": {"version": )");
    expectInputError(path, "glTF");
}

TEST(SceneLoaderBroken, JsonNestedWithoutEnd) {
    const std::string path = temporaryPath("deep.gltf");
    writeFile(path, R"({"asset":{"version":"2.0"},"extras":)" + std::string(1000000, '[') +
                        std::string(1000000, ']') + "}");
    expectInputError(path, "nested");
}

TEST(SceneLoaderBroken, OldBinaryVersion) {
    const std::string path = temporaryPath("old.glb");
    std::string bytes = sound().glb();
    bytes[4] = 1;
    writeFile(path, bytes);
    expectInputError(path, "version 1");
}

TEST(SceneLoaderBroken, EveryTruncationIsAnInputError) {
    const std::string path = temporaryPath("truncated.glb");
    const std::string bytes = sound().glb();
    for (size_t size = 1; size < bytes.size(); size += 7) {
        writeFile(path, bytes.substr(0, size));
        expectInputError(path, "");
    }
}

// Any byte may be wrong: the loader loads or complains, nothing else.
TEST(SceneLoaderBroken, NoFlippedByteCrashes) {
    const std::string path = temporaryPath("flipped.glb");
    const std::string bytes = sound().glb();
    for (size_t i = 0; i < bytes.size(); ++i) {
        std::string flipped = bytes;
        flipped[i] = static_cast<char>(flipped[i] ^ (1 << i % 7));
        writeFile(path, flipped);
        try {
            loadScene(path);
        } catch (const Error& error) {
            EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
        }
    }
}

TEST(SceneLoaderBroken, LongChainOfNodesIsNoProblem) {
    GltfFile file = oneTriangle();
    constexpr int kLength = 20000;
    for (int i = 1; i < kLength; ++i) {
        file.json["nodes"].push_back({{"children", {i - 1}}});
    }
    EXPECT_EQ(file.load().triangleCount(), 1);
}

}  // namespace
}  // namespace sheen
