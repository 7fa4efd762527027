// What of a file's surfaces is there, how often, on which sides, and cameras without perspective.
#include <cmath>

#include "scene_test_gltf.h"

namespace sheen {
namespace {

// A textured triangle whose alpha is that of its vertices: 1, 0.5 and 0.
GltfFile masked(const char* mode) {
    GltfFile file = textured();
    file.json["materials"][0]["alphaMode"] = mode;
    file.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] =
        file.addAccessor<float>({1, 1, 1, 1, 1, 1, 1, 0.5f, 1, 1, 1, 0}, kFloat, "VEC4", 4);
    return file;
}

TEST(AlphaMode, MaskLeavesOutWhatHasLessThanTheCutoff) {
    GltfFile file = masked("MASK");
    const Scene half = file.load();
    EXPECT_EQ(coverageAt(half, 0, vec3(1, 0, 0)), 1.0f);
    EXPECT_EQ(coverageAt(half, 0, vec3(0, 1, 0)), 1.0f) << "the cutoff itself is there";
    EXPECT_EQ(coverageAt(half, 0, vec3(0, 0.98f, 0.02f)), 0.0f);
    file.json["materials"][0]["alphaCutoff"] = 0.9;
    EXPECT_EQ(coverageAt(file.load(), 0, vec3(0, 1, 0)), 0.0f);
    file.json["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = {1, 1, 1, 0.8};
    EXPECT_EQ(coverageAt(file.load(), 0, vec3(1, 0, 0)), 0.0f) << "the factor counts";
    EXPECT_FALSE(warnsOf(file.load(), "alphaMode"));
}

TEST(AlphaMode, OpaqueHasNoHoles) {
    const Scene scene = masked("OPAQUE").load();
    EXPECT_EQ(coverageAt(scene, 0, vec3(0, 0, 1)), 1.0f);
}

TEST(AlphaMode, BlendStopsTheShareOfLightThatAlphaSays) {
    const Scene scene = masked("BLEND").load();
    EXPECT_NEAR(coverageAt(scene, 0, vec3(0.9f, 0, 0.1f)), 0.9f, 1e-6f);
    EXPECT_NEAR(coverageAt(scene, 0, vec3(0.1f, 0, 0.9f)), 0.1f, 1e-6f);
    EXPECT_EQ(coverageAt(scene, 0, vec3(0, 0, 1)), 0.0f);
    EXPECT_TRUE(scene.warnings.empty() || !warnsOf(scene, "BLEND"));
}

TEST(AlphaMode, BlendOfWhatIsOpaqueEverywhereIsOpaque) {
    GltfFile file = textured();
    file.json["materials"][0]["alphaMode"] = "BLEND";
    EXPECT_FALSE(file.load().materials[0].blended);
    file.json["materials"][0]["pbrMetallicRoughness"]["baseColorFactor"] = {1, 1, 1, 0.5};
    EXPECT_TRUE(file.load().materials[0].blended);
}

TEST(Instancing, ShowsAMeshWhereverAnInstanceStands) {
    GltfFile file = oneTriangle();
    const int at = file.addAccessor<float>({0, 0, 0, 5, 0, 0}, kFloat, "VEC3", 3);
    const auto half_turn = static_cast<float>(std::sqrt(0.5));
    const int turned =
        file.addAccessor<float>({0, 0, 0, 1, 0, 0, half_turn, half_turn}, kFloat, "VEC4", 4);
    const int scaled = file.addAccessor<float>({1, 1, 1, 2, 3, 1}, kFloat, "VEC3", 3);
    file.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {
        {"TRANSLATION", at}, {"ROTATION", turned}, {"SCALE", scaled}};
    file.json["nodes"][0]["translation"] = {0, 0, 7};
    file.json["extensionsUsed"] = {"EXT_mesh_gpu_instancing"};
    file.json["extensionsRequired"] = {"EXT_mesh_gpu_instancing"};
    const Scene scene = file.load();
    ASSERT_EQ(scene.triangleCount(), 2);
    const auto corner = [&](size_t triangle, int c) {
        return scene.positions[scene.triangles[triangle][c]];
    };
    EXPECT_EQ(corner(0, 1), vec3(1, 0, 7));
    // (1, 0, 0) twice as long, turned to y; (0, 1, 0) three times as long, turned to -x.
    EXPECT_LT(glm::distance(corner(1, 1), vec3(5, 2, 7)), 1e-5f);
    EXPECT_LT(glm::distance(corner(1, 2), vec3(2, 0, 7)), 1e-5f);
}

TEST(Instancing, AttributesOfDifferentLengthsAreRefused) {
    GltfFile file = oneTriangle();
    const int two = file.addAccessor<float>({0, 0, 0, 5, 0, 0}, kFloat, "VEC3", 3);
    const int one = file.addAccessor<float>({1, 1, 1}, kFloat, "VEC3", 3);
    file.json["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"] = {
        {"TRANSLATION", two}, {"SCALE", one}};
    EXPECT_THROW(file.load(), Error);
}

// A camera above the triangle, 2 high, from z = 3 on.
TEST(ParallelCamera, SeesAsMuchAtEveryDistanceAndNothingBehindItself) {
    GltfFile file = oneTriangle();
    file.json["cameras"] =
        Json::array({{{"type", "orthographic"},
                      {"orthographic", {{"xmag", 1}, {"ymag", 1}, {"znear", 0.5}, {"zfar", 9}}}}});
    file.json["nodes"].push_back({{"camera", 0}, {"translation", {0, 0, 3}}});
    const Scene scene = file.load();
    ASSERT_EQ(scene.cameras.size(), 1u);
    EXPECT_TRUE(warnsOf(scene, "orthographic camera is approximated"));
    const auto heightAt = [&](float z) {
        float y[2];
        for (int i = 0; i < 2; ++i) {
            // The upper and the lower edge of the image.
            const CameraRay ray = cameraRay(scene.cameras[0], 1, 1, 0, i == 0 ? -0.5f : 0.5f);
            EXPECT_NEAR(ray.origin.z, 2.5f, 0.01f) << "half a unit before the camera";
            y[i] = ray.origin.y + ray.direction.y / ray.direction.z * (z - ray.origin.z);
        }
        return y[0] - y[1];
    };
    EXPECT_NEAR(heightAt(0.0f), 2.0f, 0.01f);
    EXPECT_NEAR(heightAt(0.7f), 2.0f, 0.02f);
    EXPECT_NEAR(heightAt(-0.7f), 2.0f, 0.02f);
}

TEST(Features, ListWhatAFileUsesAndWhatBecomesOfIt) {
    GltfFile file = masked("MASK");
    file.json["extensionsUsed"] = {"KHR_texture_transform", "KHR_materials_dispersion"};
    file.json["materials"][0]["occlusionTexture"]["index"] = 0;
    const Scene scene = file.load();
    const auto treatment = [&](const std::string& name) {
        for (const Scene::Feature& feature : scene.features) {
            if (feature.name == name) {
                return feature.treatment;
            }
        }
        return std::string("not used");
    };
    EXPECT_EQ(treatment("KHR_texture_transform"), "right");
    EXPECT_EQ(treatment("KHR_materials_dispersion"), "ignored");
    EXPECT_EQ(treatment("alphaMode MASK"), "right");
    EXPECT_EQ(treatment("vertex colours"), "right");
    EXPECT_EQ(treatment("occlusion textures"), "ignored: the light they stand for is computed");
    EXPECT_EQ(treatment("skins"), "not used");
}

}  // namespace
}  // namespace sheen
