// The scenes with camera and lights moved: the same for a seed everywhere, nothing else changed,
// and something to see.
#include <array>
#include <filesystem>
#include <map>

#include "scene_test_files.h"
#include "scene_test_gltf.h"
#include "scenes/moved.h"
#include "test_reference.h"

namespace sheen {
namespace {

constexpr uint32_t kSeeds = 3;
constexpr double kSeen = 0.9;  // share of the pixels
// What moved() promises, and rounding of what is written.
constexpr float kLeastMove = 0.025f, kMostMove = 0.05f, kMoveRounding = 1e-4f;
const float kLeastTurn = glm::radians(2.5f), kMostTurn = glm::radians(5.0f);

std::vector<scenes::NamedScene> measuredScenes() {
    std::vector<scenes::NamedScene> measured;
    for (const scenes::NamedScene& scene : scenes::allScenes()) {
        if (scene.measured) {
            measured.push_back(scene);
        }
    }
    return measured;
}

// References are rendered of these very scenes: a new hash asks for new ones.
const std::map<std::string, std::array<uint64_t, kSeeds>> kHashes = {
    {"cornell_diffuse.glb", {0x7bbe5dd27d207065u, 0x07ec3f1633ce33bfu, 0x07ffc4fda92c8302u}},
    {"cornell_glossy.glb", {0x89c792907850d412u, 0xdfbf87af8666cacau, 0x3718249082766897u}},
    {"venus_glossy.glb", {0x335ca7c2327d0c28u, 0xd71eed5adec42728u, 0x5859a6bae020eb94u}},
    {"atrium.glb", {0xf293c6b0639472e5u, 0xdb9b466390be0b36u, 0x608e5f2461de30cfu}},
    {"corridor.glb", {0xc6d174af378a90d9u, 0x06d1d0570cea7ef9u, 0x4d28118de8b9bfd2u}},
};

Scene load(const std::vector<uint8_t>& bytes) {
    const std::string path = temporaryPath("moved.glb");
    writeFile(path, {bytes.begin(), bytes.end()});
    return loadScene(path);
}

float angleBetween(const vec3& a, const vec3& b) {
    return 2.0f * std::asin(std::min(0.5f * glm::length(a - b), 1.0f));
}

void expectMoved(const vec3& from, const vec3& to, float size) {
    EXPECT_GE(glm::length(to - from), (kLeastMove - kMoveRounding) * size);
    EXPECT_LE(glm::length(to - from), (kMostMove + kMoveRounding) * size);
}

void expectTurned(const vec3& from, const vec3& to) {
    EXPECT_GE(angleBetween(from, to), kLeastTurn - kMoveRounding);
    EXPECT_LE(angleBetween(from, to), kMostTurn + kMoveRounding);
}

void expectSameSurfaces(const Scene& a, const Scene& b) {
    EXPECT_TRUE(a.positions == b.positions);
    EXPECT_TRUE(a.normals == b.normals);
    EXPECT_TRUE(a.uvs == b.uvs);
    EXPECT_TRUE(a.triangles == b.triangles);
    EXPECT_TRUE(a.materials_of == b.materials_of);
    EXPECT_EQ(a.materials.size(), b.materials.size());
    EXPECT_EQ(a.textures.size(), b.textures.size());
}

void expectMovedLights(const Scene& still, const Scene& moved) {
    ASSERT_EQ(moved.lights.size(), still.lights.size());
    for (size_t i = 0; i < moved.lights.size(); ++i) {
        const PunctualLight& a = still.lights[i];
        const PunctualLight& b = moved.lights[i];
        EXPECT_EQ(b.kind, a.kind);
        EXPECT_EQ(b.intensity, a.intensity);
        EXPECT_EQ(b.cos_outer, a.cos_outer);
        if (a.kind != shared::LIGHT_DIRECTIONAL) {
            expectMoved(a.position, b.position, still.bounds.size());
        }
        if (a.kind != shared::LIGHT_POINT) {
            expectTurned(a.direction, b.direction);
        }
    }
}

class MovedScenes : public testing::TestWithParam<scenes::NamedScene> {};

TEST_P(MovedScenes, DifferInTheFirstCameraAndTheLightsAndSeeTheScene) {
    const scenes::Model model = GetParam().make();
    const Scene still = load(scenes::encodeGlb(model));
    for (uint32_t seed = 1; seed <= kSeeds; ++seed) {
        SCOPED_TRACE(fmt::format("seed {}", seed));
        const std::vector<uint8_t> bytes = scenes::encodeGlb(scenes::moved(model, seed));
        EXPECT_EQ(hashOf(bytes), kHashes.at(GetParam().file_name)[seed - 1])
            << fmt::format("0x{:016x}u", hashOf(bytes));
        const Scene moved = load(bytes);
        EXPECT_EQ(moved.warnings, std::vector<std::string>());
        expectSameSurfaces(still, moved);
        expectMovedLights(still, moved);

        ASSERT_EQ(moved.cameras.size(), still.cameras.size());
        const mat4& from = still.cameras[0].world_from_camera;
        const mat4& to = moved.cameras[0].world_from_camera;
        expectMoved(vec3(from[3]), vec3(to[3]), still.bounds.size());
        expectTurned(-vec3(from[2]), -vec3(to[2]));
        EXPECT_EQ(moved.cameras[0].y_fov, still.cameras[0].y_fov);
        for (size_t i = 1; i < moved.cameras.size(); ++i) {
            EXPECT_EQ(moved.cameras[i].world_from_camera, still.cameras[i].world_from_camera);
        }

        const Frame frame = firstHits(moved, 96, 96);
        double seen = 0.0;
        for (const uint32_t primitive : frame.primitive.pixels) {
            seen += primitive == kNoPrimitive ? 0.0 : 1.0 / frame.primitive.count();
        }
        EXPECT_GE(seen, kSeen);
    }
}

INSTANTIATE_TEST_SUITE_P(All, MovedScenes, testing::ValuesIn(measuredScenes()),
                         [](const auto& info) {
                             return std::filesystem::path(info.param.file_name).stem().string();
                         });

}  // namespace
}  // namespace sheen
