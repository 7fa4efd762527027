// Normal maps: the frame in which they are read, and what they make of a surface's normal.
#include <cmath>

#include "scene_test_gltf.h"

namespace sheen {
namespace {

// One triangle in z = 0, seen from +z, whose map says everywhere that the normal leans along its
// own x and y by as much: (0.5, 0.5, 0.707) as stored in bytes.
GltfFile leaning(const std::vector<float>& uvs) {
    GltfFile file = textured();
    Json& primitive = file.json["meshes"][0]["primitives"][0];
    primitive["attributes"]["TEXCOORD_0"] = file.addAccessor<float>(uvs, kFloat, "VEC2", 2);
    primitive["attributes"]["NORMAL"] =
        file.addAccessor<float>({0, 0, 1, 0, 0, 1, 0, 0, 1}, kFloat, "VEC3", 3);
    file.json["materials"][0]["normalTexture"]["index"] =
        addPicture(file, {1, 1, {{{191, 191, 218}}}});
    return file;
}

// Seen from `side` of z = 0.
vec3 normalOf(const Scene& scene, float side = 1.0f) {
    const vec3 up(0, 0, side);
    const ShadingNormals normals = normalsAt(scene, 0, vec3(1.0f / 3.0f), up, up);
    EXPECT_EQ(normals.smooth, up);
    return normals.mapped;
}

void expectNear(const vec3& n, const vec3& expected) {
    for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(n[c], expected[c], 0.005f) << c;
    }
}

const float kHalfway = std::sqrt(0.5f);

TEST(NormalMap, LeansAlongGrowingUAndFallingV) {
    // u along x, v along -y, as an image is seen.
    expectNear(normalOf(leaning({0, 0, 1, 0, 0, -1}).load()), {0.5f, 0.5f, kHalfway});
    // Turned: u along y, v along x.
    expectNear(normalOf(leaning({0, 0, 0, 1, 1, 0}).load()), {-0.5f, 0.5f, kHalfway});
    // Mirrored: v along y.
    expectNear(normalOf(leaning({0, 0, 1, 0, 0, 1}).load()), {0.5f, -0.5f, kHalfway});
}

TEST(NormalMap, FollowsTheFilesTangents) {
    GltfFile file = leaning({0, 0, 1, 0, 0, 1});
    Json& attributes = file.json["meshes"][0]["primitives"][0]["attributes"];
    attributes["TANGENT"] =
        file.addAccessor<float>({0, 1, 0, 1, 0, 1, 0, 1, 0, 1, 0, 1}, kFloat, "VEC4", 4);
    expectNear(normalOf(file.load()), {-0.5f, 0.5f, kHalfway});
    attributes["TANGENT"] =
        file.addAccessor<float>({0, 1, 0, -1, 0, 1, 0, -1, 0, 1, 0, -1}, kFloat, "VEC4", 4);
    expectNear(normalOf(file.load()), {0.5f, 0.5f, kHalfway});
    // A mirroring node mirrors what is seen, and nothing more.
    file.json["nodes"][0]["scale"] = {-1, 1, 1};
    expectNear(normalOf(file.load()), {-0.5f, 0.5f, kHalfway});
}

TEST(NormalMap, TurnsOverSeenFromTheBack) {
    expectNear(normalOf(leaning({0, 0, 1, 0, 0, -1}).load(), -1.0f), {-0.5f, -0.5f, -kHalfway});
}

TEST(NormalMap, ScalesWhatLeans) {
    GltfFile file = leaning({0, 0, 1, 0, 0, -1});
    file.json["materials"][0]["normalTexture"]["scale"] = 0.0;
    expectNear(normalOf(file.load()), {0, 0, 1});
    file.json["materials"][0]["normalTexture"]["scale"] = -1.0;
    expectNear(normalOf(file.load()), {-0.5f, -0.5f, kHalfway});
}

TEST(NormalMap, OfACoatLeavesTheSurfaceSmooth) {
    GltfFile file = leaning({0, 0, 1, 0, 0, -1});
    Json& material = file.json["materials"][0];
    material["extensions"]["KHR_materials_clearcoat"] = {
        {"clearcoatFactor", 1.0}, {"clearcoatNormalTexture", material["normalTexture"]}};
    const vec3 up(0, 0, 1);
    const auto normals = [&] { return normalsAt(file.load(), 0, vec3(1.0f / 3.0f), up, up); };
    expectNear(normals().coat, {0.5f, 0.5f, kHalfway});
    EXPECT_FALSE(warnsOf(file.load(), "clearcoat"));
    material.erase("normalTexture");
    EXPECT_EQ(normals().mapped, up);
    expectNear(normals().coat, {0.5f, 0.5f, kHalfway});
    material["extensions"]["KHR_materials_clearcoat"]["clearcoatNormalTexture"]["scale"] = 0.0;
    expectNear(normals().coat, up);
}

TEST(NormalMap, WithoutCoordinatesTheSurfaceHasSomeFrame) {
    const Scene scene = leaning({0, 0, 0, 0, 0, 0}).load();
    EXPECT_NEAR(glm::length(normalOf(scene)), 1.0f, 1e-5f);
    EXPECT_NEAR(normalOf(scene).z, kHalfway, 0.005f);
}

// A fan of two triangles that share an edge along which mirrored coordinates meet.
TEST(NormalMap, VerticesWhereMirroredCoordinatesMeetBecomeTwo) {
    GltfFile file;
    Json& primitive = file.addPrimitive({0, 0, 0, 0, 1, 0, 1, 0, 0, -1, 0, 0});
    primitive["indices"] =
        file.addAccessor<uint16_t>({0, 2, 1, 0, 1, 3}, kUnsignedShort, "SCALAR", 1);
    primitive["attributes"]["NORMAL"] =
        file.addAccessor<float>({0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1}, kFloat, "VEC3", 3);
    primitive["attributes"]["TEXCOORD_0"] =
        file.addAccessor<float>({0, 0, 0, 1, 1, 0, 1, 0}, kFloat, "VEC2", 2);
    primitive["material"] = 0;
    const int map = addPicture(file, {1, 1, {{{191, 128, 238}}}});
    file.json["materials"] = Json::array({{{"normalTexture", {{"index", map}}}}});
    const Scene scene = file.load();
    ASSERT_EQ(scene.positions.size(), 7u) << "the mirrored triangle's three are its own";
    const vec3 up(0, 0, 1);
    EXPECT_GT(normalsAt(scene, 0, vec3(1.0f / 3.0f), up, up).mapped.x, 0.4f);
    EXPECT_LT(normalsAt(scene, 1, vec3(1.0f / 3.0f), up, up).mapped.x, -0.4f);
}

}  // namespace
}  // namespace sheen
