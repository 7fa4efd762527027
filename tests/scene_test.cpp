// The loader on valid files: what is in the file arrives in world space, and what cannot be shown
// is named.
#include "scene/scene.h"

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "scene/defaults.h"
#include "scene_test_gltf.h"
#include "scenes/png.h"

namespace sheen {
namespace {

constexpr float kRounding = 1e-6f;  // a few operations on numbers near one, in float

#define EXPECT_VEC3(actual, x_, y_, z_)                 \
    do {                                                \
        const vec3 actual_ = (actual);                  \
        EXPECT_NEAR(actual_.x, (x_), kRounding) << "x"; \
        EXPECT_NEAR(actual_.y, (y_), kRounding) << "y"; \
        EXPECT_NEAR(actual_.z, (z_), kRounding) << "z"; \
    } while (false)

TEST(SceneLoader, ReadsATriangleWithFlatNormals) {
    const Scene scene = oneTriangle().load();
    ASSERT_EQ(scene.triangleCount(), 1);
    EXPECT_VEC3(scene.positions[scene.triangles[0].y], 1, 0, 0);
    for (const vec3& normal : scene.normals) {
        EXPECT_VEC3(normal, 0, 0, 1);
    }
    EXPECT_VEC3(scene.bounds.upper, 1, 1, 0);
    EXPECT_EQ(scene.warnings.size(), 2u) << "none but of the camera and the sun";
}

TEST(SceneLoader, PrimitiveWithoutMaterialGetsTheDefaultOne) {
    const Scene scene = oneTriangle().load();
    const Material& material = scene.materials[scene.materials_of[0]];
    EXPECT_VEC3(material.params.base_color, 1, 1, 1);
    EXPECT_EQ(material.params.metallic, 1.0f);
    EXPECT_EQ(material.params.roughness, 1.0f);
    EXPECT_VEC3(material.params.emission, 0, 0, 0);
}

TEST(SceneLoader, ReadsTextFilesWithExternalBuffers) {
    GltfFile file = oneTriangle();
    writeFile(temporaryPath("data.bin"), file.binary);
    file.json["buffers"] = Json::array({{{"uri", "data.bin"}, {"byteLength", file.binary.size()}}});
    const std::string path = temporaryPath("scene.gltf");
    writeFile(path, file.json.dump());
    EXPECT_EQ(loadScene(path).triangleCount(), 1);
}

TEST(SceneLoader, AppliesNodeTransformsFromParentToChild) {
    GltfFile file = oneTriangle();
    const float s = std::sqrt(0.5f);
    file.json["nodes"][0]["scale"] = {2, 2, 2};
    file.json["nodes"][0]["rotation"] = {0, 0, s, s};  // a quarter turn about z
    file.json["nodes"][0]["translation"] = {10, 0, 0};
    file.json["nodes"].push_back(
        {{"matrix", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 5, 0, 1}}, {"children", {0}}});
    const Scene scene = file.load();
    const uvec3 t = scene.triangles[0];
    EXPECT_VEC3(scene.positions[t.x], 10, 5, 0);
    EXPECT_VEC3(scene.positions[t.y], 10, 7, 0);
    EXPECT_VEC3(scene.positions[t.z], 8, 5, 0);
}

TEST(SceneLoader, MirroredTransformKeepsTheFrontInFront) {
    GltfFile file = oneTriangle();
    file.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] =
        file.addAccessor<float>({0, 0, 1, 0, 0, 1, 0, 0, 1}, kFloat, "VEC3", 3);
    file.json["nodes"][0]["scale"] = {-1, 1, 1};
    const Scene scene = file.load();
    EXPECT_VEC3(geometricNormal(scene, 0), 0, 0, 1);
    EXPECT_VEC3(scene.normals[scene.triangles[0].x], 0, 0, 1);
}

TEST(SceneLoader, NormalsGoByTheInverseTranspose) {
    GltfFile file;
    // A slope in x and y, squeezed in x.
    Json& primitive = file.addPrimitive({0, 0, 0, 1, -1, 0, 0, 0, -1});
    const float s = std::sqrt(0.5f);
    primitive["attributes"]["NORMAL"] =
        file.addAccessor<float>({s, s, 0, s, s, 0, s, s, 0}, kFloat, "VEC3", 3);
    file.json["nodes"][0]["scale"] = {0.25, 1, 1};
    const Scene scene = file.load();
    EXPECT_GT(glm::dot(scene.normals[0], geometricNormal(scene, 0)) *
                  glm::dot(scene.normals[0], geometricNormal(scene, 0)),
              1.0f - kRounding);
}

TEST(SceneLoader, SingularTransformFlattensWithoutBreaking) {
    GltfFile file;
    file.addPrimitive({0, 0, 0, 1, 0, 0, 0, 1, 0.5f});
    file.json["nodes"][0]["scale"] = {1, 1, 0};
    const Scene flat = file.load();
    ASSERT_EQ(flat.triangleCount(), 1);
    EXPECT_VEC3(flat.normals[0], 0, 0, 1);
    file.json["nodes"][0]["scale"] = {0, 0, 0};
    const Scene gone = file.load();
    EXPECT_EQ(gone.triangleCount(), 0);
    EXPECT_TRUE(warnsOf(gone, "without area"));
}

TEST(SceneLoader, ReadsIndicesOfEveryWidth) {
    const auto load = [](auto index, int type) {
        GltfFile file;
        Json& primitive = file.addPrimitive(kTriangle);
        using Index = decltype(index);
        primitive["indices"] = file.addAccessor<Index>({0, 1, 2, 2, 1, 0}, type, "SCALAR", 1);
        return file.load();
    };
    for (const Scene& scene : {load(uint8_t{}, kUnsignedByte), load(uint16_t{}, kUnsignedShort),
                               load(uint32_t{}, kUnsignedInt)}) {
        ASSERT_EQ(scene.triangleCount(), 2);
        EXPECT_VEC3(geometricNormal(scene, 0), 0, 0, 1);
        EXPECT_VEC3(geometricNormal(scene, 1), 0, 0, -1);
    }
}

TEST(SceneLoader, StripsAndFansFaceOneWay) {
    const auto load = [](const std::vector<float>& positions, int mode) {
        GltfFile file;
        file.addPrimitive(positions)["mode"] = mode;
        return file.load();
    };
    const Scene strip = load({0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0, 0, 2, 0}, 5);
    const Scene fan = load({0, 0, 0, 1, 0, 0, 1, 1, 0, 0, 1, 0, -1, 1, 0}, 6);
    for (const Scene& scene : {strip, fan}) {
        ASSERT_EQ(scene.triangleCount(), 3);
        for (int i = 0; i < 3; ++i) {
            EXPECT_VEC3(geometricNormal(scene, i), 0, 0, 1);
        }
    }
}

TEST(SceneLoader, SparseAccessorsReplaceTheirElements) {
    GltfFile file = oneTriangle();
    const int indices = file.addView<uint16_t>({1});
    const int values = file.addView<float>({3, 0, 0});
    file.json["accessors"][0]["sparse"] = {
        {"count", 1},
        {"indices", {{"bufferView", indices}, {"componentType", kUnsignedShort}}},
        {"values", {{"bufferView", values}}}};
    EXPECT_VEC3(file.load().bounds.upper, 3, 1, 0);
}

TEST(SceneLoader, NormalizedTexcoordsBecomeZeroToOne) {
    GltfFile file = oneTriangle();
    const int uv =
        file.addAccessor<uint16_t>({0, 65535, 65535, 0, 13107, 0}, kUnsignedShort, "VEC2", 2);
    file.json["accessors"][static_cast<size_t>(uv)]["normalized"] = true;
    file.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = uv;
    const Scene scene = file.load();
    EXPECT_EQ(scene.uvs[scene.triangles[0].x], vec2(0, 1));
    EXPECT_NEAR(scene.uvs[scene.triangles[0].z].x, 0.2f, kRounding);
}

TEST(SceneLoader, BadNormalsBecomeGeometricOnesAndAreCounted) {
    GltfFile file = oneTriangle();
    const float nan = std::nanf("");
    file.json["meshes"][0]["primitives"][0]["attributes"]["NORMAL"] =
        file.addAccessor<float>({0, 0, 0, nan, 0, 0, 0, 0, 2}, kFloat, "VEC3", 3);
    const Scene scene = file.load();
    for (const vec3& normal : scene.normals) {
        EXPECT_VEC3(normal, 0, 0, 1);
    }
    EXPECT_TRUE(warnsOf(scene, "geometric one (2 times)"));
}

TEST(SceneLoader, DegenerateTrianglesAreLeftOutAndCounted) {
    GltfFile file;
    const float inf = INFINITY;
    file.addPrimitive({0, 0, 0, 1,   0, 0, 0, 1, 0,    // sound
                       0, 0, 0, 1,   0, 0, 2, 0, 0,    // on a line
                       1, 1, 1, 1,   1, 1, 1, 1, 1,    // a point
                       0, 0, 0, inf, 0, 0, 0, 1, 0});  // infinite
    const Scene scene = file.load();
    EXPECT_EQ(scene.triangleCount(), 1);
    EXPECT_TRUE(warnsOf(scene, "triangle without area left out"));
    EXPECT_FALSE(warnsOf(scene, "without area left out (")) << "what collapsed closes no hole";
    EXPECT_TRUE(warnsOf(scene, "not finite left out"));
    EXPECT_VEC3(scene.bounds.upper, 1, 1, 0);
}

TEST(SceneLoader, ReadsMaterialFactorsAndExtensions) {
    GltfFile file = oneTriangle();
    file.json["materials"] =
        Json::array({{{"name", "paint"},
                      {"pbrMetallicRoughness",
                       {{"baseColorFactor", {0.1, 0.2, 0.3, 1}},
                        {"metallicFactor", 0.25},
                        {"roughnessFactor", 0.5}}},
                      {"emissiveFactor", {1, 0.5, 0}},
                      {"extensions",
                       {{"KHR_materials_emissive_strength", {{"emissiveStrength", 40}}},
                        {"KHR_materials_specular",
                         {{"specularFactor", 0.75}, {"specularColorFactor", {2, 1, 0}}}}}}}});
    file.json["meshes"][0]["primitives"][0]["material"] = 0;
    const Scene scene = file.load();
    const Material& material = scene.materials[scene.materials_of[0]];
    EXPECT_EQ(material.name, "paint");
    EXPECT_VEC3(material.params.base_color, 0.1f, 0.2f, 0.3f);
    EXPECT_EQ(material.params.metallic, 0.25f);
    EXPECT_EQ(material.params.roughness, 0.5f);
    EXPECT_VEC3(material.params.emission, 40, 20, 0);
    EXPECT_EQ(material.params.specular, 0.75f);
    EXPECT_VEC3(material.params.specular_color, 2, 1, 0);
}

TEST(SceneLoader, DecodesBaseColorTexturesToLinearLight) {
    const Scene scene = textured().load();
    ASSERT_EQ(scene.textures.size(), 1u);
    const Texture& texture = scene.textures[0];
    EXPECT_EQ(texture.wrap, glm::ivec2(shared::WRAP_CLAMP, shared::WRAP_MIRROR));
    const std::vector<vec4> texels = linearTexels(scene.images[0], texture.srgb);
    EXPECT_VEC3(texels[0], 0, 0, 0);
    EXPECT_VEC3(texels[1], 1, 1, 1);
    EXPECT_NEAR(texels[2].x, 0.2158605f, kRounding);  // sRGB 128 / 255
    EXPECT_VEC3(texels[3], 1, 0, 0);
    EXPECT_EQ(scene.warnings.size(), 2u) << "none but of the camera and the sun";
}

TEST(SceneLoader, MaterialsShareATexture) {
    GltfFile file = textured();
    file.json["materials"].push_back(file.json["materials"][0]);
    EXPECT_EQ(file.load().textures.size(), 1u);
}

GltfFile withLight(const Json& light) {
    GltfFile file = oneTriangle();
    file.json["extensions"]["KHR_lights_punctual"]["lights"] = Json::array({light});
    file.json["nodes"].push_back(
        {{"translation", {1, 2, 3}},
         {"rotation", {-std::sqrt(0.5), 0, 0, std::sqrt(0.5)}},  // -z turns to -y
         {"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}});
    return file;
}

TEST(SceneLoader, ReadsAPointLight) {
    const Scene scene =
        withLight({{"type", "point"}, {"intensity", 10}, {"color", {1, 0.5, 0}}, {"range", 4}})
            .load();
    ASSERT_EQ(scene.lights.size(), 1u);
    const PunctualLight& light = scene.lights[0];
    EXPECT_EQ(light.kind, shared::LIGHT_POINT);
    EXPECT_VEC3(light.position, 1, 2, 3);
    EXPECT_VEC3(light.intensity, 10, 5, 0);
    EXPECT_EQ(light.inverse_range, 0.25f);
    EXPECT_EQ(light.spot_scale, 0.0f);
    EXPECT_EQ(light.spot_offset, 1.0f);
}

TEST(SceneLoader, ReadsASpotLightThatShinesAlongItsNode) {
    const Scene scene =
        withLight({{"type", "spot"}, {"spot", {{"innerConeAngle", 0.3}, {"outerConeAngle", 0.6}}}})
            .load();
    const PunctualLight& light = scene.lights.at(0);
    EXPECT_EQ(light.kind, shared::LIGHT_SPOT);
    EXPECT_VEC3(light.direction, 0, -1, 0);
    EXPECT_NEAR(std::cos(0.3f) * light.spot_scale + light.spot_offset, 1.0f, 1e-5f);
    EXPECT_NEAR(std::cos(0.6f) * light.spot_scale + light.spot_offset, 0.0f, 1e-5f);
    EXPECT_NEAR(light.cos_outer, std::cos(0.6f), kRounding);
}

TEST(SceneLoader, ReadsADirectionalLight) {
    const Scene scene = withLight({{"type", "directional"}, {"intensity", 100}}).load();
    EXPECT_EQ(scene.lights.at(0).kind, shared::LIGHT_DIRECTIONAL);
    EXPECT_VEC3(scene.lights[0].direction, 0, -1, 0);
}

TEST(SceneLoader, CameraPosesAreRigid) {
    GltfFile file = oneTriangle();
    file.json["cameras"] =
        Json::array({{{"type", "perspective"},
                      {"perspective", {{"yfov", 0.8}, {"aspectRatio", 1.5}, {"znear", 0.1}}}}});
    file.json["nodes"].push_back(
        {{"name", "eye"}, {"camera", 0}, {"scale", {-2, 3, 4}}, {"translation", {0, 1, 5}}});
    const Scene scene = file.load();
    ASSERT_EQ(scene.cameras.size(), 1u);
    EXPECT_FALSE(warnsOf(scene, "camera"));
    const Camera& camera = scene.cameras[0];
    EXPECT_EQ(camera.name, "eye");
    EXPECT_EQ(camera.aspect, 1.5f);
    EXPECT_NEAR(glm::determinant(mat3(camera.world_from_camera)), 1.0f, kRounding);
    EXPECT_VEC3(vec3(camera.world_from_camera[2]), 0, 0, 1);
    EXPECT_VEC3(vec3(camera.world_from_camera[1]), 0, 1, 0);
    EXPECT_VEC3(vec3(camera.world_from_camera[3]), 0, 1, 5);
}

TEST(SceneLoader, SceneWithoutCamerasGetsOneThatSeesAllOfItAndSaysSo) {
    const Scene scene = oneTriangle().load();
    ASSERT_EQ(scene.cameras.size(), 1u);
    EXPECT_TRUE(warnsOf(scene, "no camera"));
    const mat4 camera_from_world = glm::inverse(scene.cameras[0].world_from_camera);
    const float tan_half = std::tan(0.5f * scene.cameras[0].y_fov);
    for (const vec3& p : scene.positions) {
        const vec3 q(camera_from_world * vec4(p, 1.0f));
        ASSERT_LT(q.z, 0.0f);
        EXPECT_LT(std::abs(q.x / q.z), tan_half);
        EXPECT_LT(std::abs(q.y / q.z), tan_half);
    }
}

TEST(SceneLoader, SceneThatWouldBeBlackGetsAStudioAndSaysSo) {
    GltfFile file = oneTriangle();
    const Scene dark = file.load();
    ASSERT_EQ(dark.lights.size(), 1u);
    EXPECT_EQ(dark.light_names, std::vector<std::string>{"default"});
    const LightSample sun = shared::sampleLight(dark.lights[0], vec3(0.0f));
    EXPECT_GT(sun.wi.y, 0.5f) << "from above";
    EXPECT_VEC3(sun.irradiance, kPi, kPi, kPi);
    EXPECT_TRUE(warnsOf(dark, "no light and nothing that emits"));

    file.json["materials"] = Json::array({{{"emissiveFactor", {0, 0.1, 0}}}});
    EXPECT_EQ(file.load().lights.size(), 1u) << "nothing is made of it";
    file.json["meshes"][0]["primitives"][0]["material"] = 0;
    const Scene glowing = file.load();
    EXPECT_TRUE(glowing.lights.empty());
    EXPECT_FALSE(warnsOf(glowing, "no light"));
}

TEST(SceneDefaults, KeyLightComesFromTheLeftOfTheFirstCamera) {
    for (const float turn : {0.0f, 1.0f, 3.0f}) {
        Camera camera;  // looks along -z
        camera.world_from_camera =
            glm::rotate(glm::rotate(mat4(1.0f), turn, vec3(0, 1, 0)), -0.4f, vec3(1, 0, 0));
        const mat3 axes(camera.world_from_camera);
        const vec3 wi = -keyLight(camera).direction;
        EXPECT_GT(wi.y, 0.7f);
        EXPECT_LT(glm::dot(wi, axes[0]), -0.2f) << "from the left";
        EXPECT_GT(glm::dot(wi, axes[2]), 0.2f) << "from the camera's side";
        EXPECT_NEAR(glm::length(wi), 1.0f, kRounding);
    }
    // Straight down and up.
    for (const float tilt : {-0.5f * kPi, 0.5f * kPi}) {
        Camera camera;
        camera.world_from_camera = glm::rotate(mat4(1.0f), tilt, vec3(1, 0, 0));
        const vec3 wi = -keyLight(camera).direction;
        EXPECT_LT(wi.x, -0.2f);
        EXPECT_GT(wi.z, 0.2f);
    }
}

// As the camera turns about the vertical, so do key and sky: from the first camera every file looks
// alike. Of a level white surface in the key's shadow the sky makes a radiance of 0.78.
TEST(SceneDefaults, TheStudioIsSetUpAboutTheFirstCamera) {
    const Environment straight = studioSky(Camera{});
    for (const float turn : {0.5f, 2.0f, -3.0f}) {
        const mat4 turned = glm::rotate(mat4(1.0f), turn, vec3(0, 1, 0));
        const Environment sky = studioSky({.name = "", .world_from_camera = turned});
        for (const vec3& way : {vec3(-1, 0.2f, 0), vec3(1, 0.4f, -0.3f), vec3(0, -1, 0.1f)}) {
            const vec3 d = glm::normalize(way);
            const vec3 there = sky.radiance(mat3(turned) * d);
            EXPECT_NEAR(there.x, straight.radiance(d).x, 1e-3f);
            EXPECT_EQ(there.x, there.y);
            EXPECT_EQ(there.x, there.z);
        }
    }
    double level = 0.0;
    const Image<vec3>& texels = straight.texels;
    for (int y = 0; y < texels.height / 2; ++y) {
        const double theta = kPi * (y + 0.5) / texels.height;
        for (int x = 0; x < texels.width; ++x) {
            level += texels.at(x, y).x * std::sin(theta) * std::cos(theta) * kPi / texels.height *
                     2.0 * kPi / texels.width / kPi;
        }
    }
    EXPECT_NEAR(level, 0.78, 0.01);
    EXPECT_GT(straight.radiance(vec3(0, 1, 0)).x, 2.0f * straight.radiance(vec3(0, -1, 0)).x);
    const vec3 key = -keyLight(Camera{}).direction;
    EXPECT_GT(straight.radiance(key).x, straight.radiance(vec3(-key.x, key.y, -key.z)).x);
}

TEST(SceneDefaults, TheStudioCanBeLeftOutOrBeUnseen) {
    const std::string path = oneTriangle().write();
    const Scene studio = loadScene(path);
    EXPECT_TRUE(studio.environment.shows());
    EXPECT_TRUE(warnsOf(studio, "a studio's grey sky"));
    const Scene unseen = loadScene(path, {.environment = {.source = "", .transparent = true}});
    EXPECT_FALSE(unseen.environment.empty());
    EXPECT_FALSE(unseen.environment.shows());
    const Scene no_sky = loadScene(path, {.environment = {.source = "", .no_sky = true}});
    EXPECT_TRUE(no_sky.environment.empty());
    EXPECT_EQ(no_sky.lights.size(), 1u);
    EXPECT_TRUE(warnsOf(no_sky, "lit by a key light"));
}

TEST(SceneDefaults, NothingIsAddedWhereTheEnvironmentIsNamed) {
    const std::string path = oneTriangle().write();
    EXPECT_EQ(loadScene(path).lights.size(), 1u);
    const Scene none = loadScene(path, {.environment = {.source = "none"}});
    EXPECT_TRUE(none.lights.empty());
    EXPECT_TRUE(none.environment.empty());
    const Scene lit = loadScene(path, {.environment = {.source = "1,1,1"}});
    EXPECT_TRUE(lit.lights.empty());
    EXPECT_TRUE(lit.environment.shows());
}

TEST(SceneLoader, EmptySceneIsLegalAndSaysSo) {
    const Scene scene = GltfFile().load();
    EXPECT_TRUE(scene.lights.empty()) << "nothing to light";
    EXPECT_EQ(scene.triangleCount(), 0);
    EXPECT_TRUE(scene.bounds.empty());
    EXPECT_EQ(scene.cameras.size(), 1u);
    EXPECT_TRUE(warnsOf(scene, "no geometry"));
}

TEST(SceneLoader, OnlyTheDefaultSceneIsShown) {
    GltfFile file = oneTriangle();
    file.json["nodes"].push_back({{"mesh", 0}});
    file.json["nodes"].push_back({{"mesh", 0}});
    EXPECT_EQ(file.load().triangleCount(), 3) << "without scenes: all roots";
    file.json["scenes"] = Json::array({{{"nodes", {0}}}, {{"nodes", {1, 2}}}});
    EXPECT_EQ(file.load().triangleCount(), 1) << "without a default: the first";
    file.json["scene"] = 1;
    EXPECT_EQ(file.load().triangleCount(), 2);
}

TEST(SceneLoader, NamesWhatItLeavesOut) {
    GltfFile file = textured();
    Json& material = file.json["materials"][0];
    material["pbrMetallicRoughness"]["baseColorTexture"]["texCoord"] = 2;
    material["alphaMode"] = "BLEND";
    file.json["meshes"][0]["primitives"].push_back(
        {{"attributes", {{"POSITION", 0}}}, {"mode", 1}});
    file.json["nodes"][0]["camera"] = 0;
    file.json["cameras"] =
        Json::array({{{"type", "orthographic"},
                      {"orthographic", {{"xmag", 1}, {"ymag", 1}, {"znear", 0.1}, {"zfar", 9}}}}});
    file.json["extensionsUsed"] = {"KHR_materials_dispersion"};
    const Scene scene = file.load();
    EXPECT_EQ(scene.triangleCount(), 1);
    for (const char* text :
         {"TEXCOORD_2", "points and lines", "orthographic", "KHR_materials_dispersion"}) {
        EXPECT_TRUE(warnsOf(scene, text)) << text;
    }
}

TEST(SceneLoader, TexturesWithoutCoordinatesAreWarnedOf) {
    GltfFile file = textured();
    EXPECT_FALSE(warnsOf(file.load(), "without TEXCOORD_0"));
    file.json["meshes"][0]["primitives"][0]["attributes"].erase("TEXCOORD_0");
    EXPECT_TRUE(warnsOf(file.load(), "without TEXCOORD_0"));
}

TEST(SceneCamera, IsFoundByNameAndByIndex) {
    Scene scene;
    scene.cameras = {{.name = "front"}, {.name = "7"}, {.name = "back"}};
    EXPECT_EQ(findCamera(scene, "").name, "front");
    EXPECT_EQ(findCamera(scene, "back").name, "back");
    EXPECT_EQ(findCamera(scene, "2").name, "back");
    EXPECT_EQ(&findCamera(scene, "7"), &scene.cameras[1]);
    try {
        findCamera(scene, "side");
        FAIL();
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ExitCode::kUsage);
        EXPECT_NE(std::string(error.what()).find("front"), std::string::npos);
    }
}

TEST(SceneCamera, RaysPassThroughPixelCentres) {
    Camera camera;
    camera.y_fov = 2.0f * std::atan(0.5f);
    camera.world_from_camera[3] = vec4(1, 2, 3, 1);
    const CameraRay middle = cameraRay(camera, 3, 3, 1.0f, 1.0f);
    EXPECT_VEC3(middle.origin, 1, 2, 3);
    EXPECT_VEC3(middle.direction, 0, 0, -1);
    // The first pixel of a 4 x 2 image: at (-3/4 * 2, 1/2) of the half height 0.5.
    const vec3 d = cameraRay(camera, 4, 2, 0.0f, 0.0f).direction;
    EXPECT_NEAR(d.x / -d.z, -0.75f, kRounding);
    EXPECT_NEAR(d.y / -d.z, 0.25f, kRounding);
    EXPECT_NEAR(glm::length(d), 1.0f, kRounding);
}

}  // namespace
}  // namespace sheen
