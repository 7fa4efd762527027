// The scenes that come with Sheen: the committed files are what the program makes, are small, and
// change only on purpose.
#include "scene_test_files.h"

#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>

#include "scene_test_gltf.h"

namespace sheen {
namespace {

constexpr size_t kLargestFile = 2'000'000;

std::vector<uint8_t> committed(const std::string& name) {
    std::ifstream in(std::string(SHEEN_SCENES) + "/" + name, std::ios::binary);
    return {std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
}

struct Expected {
    uint64_t hash;
    int fewest_triangles;
    int most_triangles;
    size_t lights;
    bool moves = false;
};
// Charts and reference images are made from these very files: a new hash asks for new ones.
const std::map<std::string, Expected> kExpected = {
    {"atrium.glb", {0x7c5bc9b6cd705e8bu, 66000, 80000, 2}},
    {"cornell_diffuse.glb", {0x1248a38ae7cf0d20u, 30, 30, 1}},
    {"cornell_glossy.glb", {0x2f9a97660af6509au, 30, 30, 1}},
    {"corridor.glb", {0xaadc1157dab7a341u, 80, 80, 5}},
    {"doors.glb", {0x708bf878728b076au, 72, 72, 2, true}},
    {"furnace.glb", {0x73d5882510290dd1u, 20492, 20492, 0}},
    {"gallery.glb", {0xa381c891d43693dfu, 47800, 47800, 0}},
    {"kite.glb", {0xa416c387ab889739u, 14, 14, 1, true}},
    {"lamp_room.glb", {0xd6f450b57458d047u, 5730, 5730, 0}},
    {"ledges.glb", {0xd848d9e8fcc9ad38u, 870, 870, 2}},
    {"orbit.glb", {0x43d30a2bd8e51a00u, 22000, 26000, 2, true}},
    {"sphere_room.glb", {0xcd00d35897d7de3cu, 20480, 20480, 1}},
    {"tiles.glb", {0xbd98ade8bce4db66u, 108, 108, 2}},
    {"venus_glossy.glb", {0xa522fe1e1b2b3a63u, 22000, 26000, 2}},
};

class SceneFiles : public testing::TestWithParam<scenes::NamedScene> {};

TEST_P(SceneFiles, AreWhatTheProgramMakes) {
    // Not EXPECT_EQ: it would print hundreds of thousands of bytes.
    EXPECT_TRUE(scenes::encodeGlb(GetParam().make()) == committed(GetParam().file_name))
        << "run make_scenes scenes";
}

TEST_P(SceneFiles, AreSmallAndFrozen) {
    const std::vector<uint8_t> bytes = committed(GetParam().file_name);
    EXPECT_LT(bytes.size(), kLargestFile);
    EXPECT_EQ(hashOf(bytes), kExpected.at(GetParam().file_name).hash)
        << fmt::format("0x{:016x}", hashOf(bytes));
}

TEST_P(SceneFiles, LoadWithoutWarnings) {
    const Expected& expected = kExpected.at(GetParam().file_name);
    const Scene scene = loadScene(std::string(SHEEN_SCENES) + "/" + GetParam().file_name);
    EXPECT_EQ(scene.warnings.size(), expected.moves ? 1u : 0u);
    EXPECT_EQ(warnsOf(scene, "the file is animated"), expected.moves);
    EXPECT_GE(scene.triangleCount(), expected.fewest_triangles);
    EXPECT_LE(scene.triangleCount(), expected.most_triangles);
    EXPECT_EQ(scene.lights.size(), expected.lights);
    EXPECT_GE(scene.cameras.size(), 1u);
}

// Vertex normals that oppose their triangle would be silently turned round when shading.
TEST_P(SceneFiles, HaveNormalsOnTheFrontOfTheirTriangles) {
    const Scene scene = loadScene(std::string(SHEEN_SCENES) + "/" + GetParam().file_name);
    int opposed = 0;
    for (int i = 0; i < scene.triangleCount(); ++i) {
        const uvec3& t = scene.triangles[static_cast<size_t>(i)];
        const vec3 mean = scene.normals[t.x] + scene.normals[t.y] + scene.normals[t.z];
        opposed += glm::dot(mean, geometricNormal(scene, i)) < 0.0f ? 1 : 0;
    }
    // The statue has creases narrower than its triangles.
    EXPECT_LE(opposed, scene.triangleCount() / 500);
}

INSTANTIATE_TEST_SUITE_P(All, SceneFiles, testing::ValuesIn(scenes::allScenes()),
                         [](const auto& info) {
                             return std::filesystem::path(info.param.file_name).stem().string();
                         });

}  // namespace
}  // namespace sheen
