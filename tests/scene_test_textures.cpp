// The material at a point of a surface, as files describe it: textures of every use, coordinates,
// colours of vertices.
#include <cmath>

#include "scene_test_gltf.h"

namespace sheen {
namespace {

constexpr float kTexelRounding = 1e-6f;

void expectVec3(const vec3& value, const vec3& expected, const std::string& of = {}) {
    for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(value[c], expected[c], kTexelRounding) << of << " " << c;
    }
}

// Of one texel.
scenes::Picture plain(uint8_t r, uint8_t g, uint8_t b) { return {1, 1, {{{r, g, b}}}}; }

MaterialParams atCorner(const Scene& scene, int corner) {
    vec3 barycentric(0.0f);
    barycentric[corner] = 1.0f;
    return materialAt(scene, 0, barycentric);
}

TEST(TextureUses, MetallicRoughnessIsGreenAndBlueAsStored) {
    GltfFile file = textured();
    Json& pbr = file.json["materials"][0]["pbrMetallicRoughness"];
    pbr["metallicFactor"] = 0.5;
    pbr["roughnessFactor"] = 0.25;
    pbr["metallicRoughnessTexture"]["index"] = addPicture(file, plain(9, 153, 51));
    const MaterialParams at = atCorner(file.load(), 0);
    EXPECT_NEAR(at.roughness, 0.25f * 0.6f, kTexelRounding);
    EXPECT_NEAR(at.metallic, 0.5f * 0.2f, kTexelRounding);
}

TEST(TextureUses, EmissionIsSrgbTimesFactorAndStrength) {
    GltfFile file = textured();
    Json& material = file.json["materials"][0];
    material["emissiveFactor"] = {1, 0.5, 0.25};
    material["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"] = 10.0;
    material["emissiveTexture"]["index"] = addPicture(file, plain(128, 255, 0));
    const Scene scene = file.load();
    EXPECT_TRUE(scene.materials[0].emits());
    const vec3 expected(10.0f * 0.2158605f, 5.0f, 0.0f);
    EXPECT_NEAR(emissionAt(scene, 0, vec3(1, 0, 0)).x, expected.x, 1e-5f);
    EXPECT_EQ(emissionAt(scene, 0, vec3(1, 0, 0)).y, expected.y);
    EXPECT_EQ(atCorner(scene, 0).emission, emissionAt(scene, 0, vec3(1, 0, 0)));
    EXPECT_NEAR(meanEmission(scene, 0).y, expected.y, kTexelRounding);
}

// Of a texture that is white where u < 1/2: over the triangle's area, three quarters of it.
TEST(TextureUses, MeanEmissionIsThatOfTheArea) {
    GltfFile file = textured();
    scenes::Picture half{64, 1, {}};
    for (int i = 0; i < 64; ++i) {
        const auto value = static_cast<uint8_t>(i < 32 ? 255 : 0);
        half.pixels.push_back({value, value, value});
    }
    file.json["materials"][0]["emissiveFactor"] = {2, 2, 2};
    file.json["materials"][0]["emissiveTexture"]["index"] = addPicture(file, half);
    EXPECT_NEAR(meanEmission(file.load(), 0).x, 2.0f * 0.75f, 0.02f);
}

TEST(TextureUses, AnEmissiveTextureThatCannotBeReadIsDark) {
    GltfFile file = textured();
    file.json["materials"][0]["emissiveFactor"] = {1, 1, 1};
    EXPECT_TRUE(file.load().materials[0].emits());
    file.json["textures"].push_back(Json::object());
    file.json["materials"][0]["emissiveTexture"]["index"] = 1;
    EXPECT_FALSE(file.load().materials[0].emits());
}

TEST(TextureUses, SpecularColorIsSrgbAndSpecularIsAlpha) {
    GltfFile file = textured();
    Json& specular = file.json["materials"][0]["extensions"]["KHR_materials_specular"];
    specular["specularFactor"] = 0.5;
    specular["specularColorFactor"] = {1, 2, 1};
    const int picture = addPicture(file, plain(128, 255, 0));
    specular["specularTexture"]["index"] = picture;  // without alpha: 1
    specular["specularColorTexture"]["index"] = picture;
    const MaterialParams at = atCorner(file.load(), 0);
    EXPECT_EQ(at.specular, 0.5f);
    expectVec3(at.specular_color, vec3(0.2158605f, 2.0f, 0.0f));
}

TEST(TextureUses, OneImageIsKeptOnceHoweverItIsLookedUp) {
    GltfFile file = textured();
    file.json["textures"].push_back({{"source", 0}});
    file.json["materials"].push_back(file.json["materials"][0]);
    file.json["materials"].push_back(file.json["materials"][0]);
    file.json["materials"][2]["emissiveTexture"]["index"] = 1;
    file.json["materials"][2]["pbrMetallicRoughness"]["metallicRoughnessTexture"]["index"] = 1;
    const Scene scene = file.load();
    EXPECT_EQ(scene.images.size(), 1u);
    EXPECT_EQ(scene.textures.size(), 3u) << "clamped; repeated, sRGB; repeated, linear";
    EXPECT_EQ(scene.images[0].bytes.size(), 4u * 4u) << "a byte a channel";
}

TEST(TextureCoordinates, SecondOnesAreOfTheTexturesThatAskForThem) {
    GltfFile file = textured();
    Json& material = file.json["materials"][0];
    material["pbrMetallicRoughness"]["baseColorTexture"]["texCoord"] = 1;
    Json& primitive = file.json["meshes"][0]["primitives"][0];
    primitive["attributes"]["TEXCOORD_1"] =
        file.addAccessor<float>({1, 0, 1, 0, 1, 1}, kFloat, "VEC2", 2);
    const Scene scene = file.load();
    expectVec3(atCorner(scene, 0).base_color, vec3(1.0f), "white at (1, 0)");
    expectVec3(atCorner(scene, 2).base_color, vec3(1, 0, 0), "red at (1, 1)");
    EXPECT_FALSE(warnsOf(scene, "TEXCOORD"));
    primitive["attributes"].erase("TEXCOORD_1");
    EXPECT_TRUE(warnsOf(file.load(), "without TEXCOORD_1"));
}

TEST(TextureCoordinates, AMeshWithoutThemIsWarnedOf) {
    GltfFile file = textured();
    EXPECT_FALSE(warnsOf(file.load(), "without TEXCOORD_0"));
    file.json["meshes"][0]["primitives"][0]["attributes"].erase("TEXCOORD_0");
    EXPECT_TRUE(warnsOf(file.load(), "without TEXCOORD_0"));
}

// Meshes before and after the one that has them.
TEST(TextureCoordinates, VerticesThatLackThemHaveNeutralOnes) {
    GltfFile file = oneTriangle();
    Json& second = file.addPrimitive(kTriangle);
    second["attributes"]["TEXCOORD_1"] =
        file.addAccessor<float>({1, 0, 1, 0, 1, 1}, kFloat, "VEC2", 2);
    second["attributes"]["COLOR_0"] =
        file.addAccessor<float>({0, 0, 0, 0, 0, 0, 0, 0, 0}, kFloat, "VEC3", 3);
    file.addPrimitive(kTriangle);
    const Scene scene = file.load();
    ASSERT_EQ(scene.colors.size(), 9u);
    ASSERT_EQ(scene.second_uvs.size(), 9u);
    for (size_t i = 0; i < 9; ++i) {
        EXPECT_EQ(scene.colors[i], i / 3 == 1 ? vec4(0, 0, 0, 1) : vec4(1.0f)) << i;
        EXPECT_EQ(scene.second_uvs[i] == vec2(0.0f), i / 3 != 1) << i;
    }
    EXPECT_TRUE(oneTriangle().load().colors.empty());
}

// Offset, rotation and scale one after the other, on the corner (0, 1) of the triangle.
TEST(TextureTransform, IsScaleThenRotationThenOffset) {
    GltfFile file = textured();
    Json& texture = file.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"];
    const auto uv = [&](const Json& transform) {
        texture["extensions"]["KHR_texture_transform"] = transform;
        const TextureUse use = file.load().materials[0].textures[shared::TEXTURE_BASE_COLOR];
        return vec3(shared::transformedUv(use.transform, vec2(0, 1)), 0.0f);
    };
    expectVec3(uv(Json::object()), vec3(0, 1, 0));
    expectVec3(uv({{"scale", {2, 3}}}), vec3(0, 3, 0));
    // Counter-clockwise, while v points down.
    expectVec3(uv({{"rotation", kPi / 2}}), vec3(1, 0, 0));
    expectVec3(uv({{"rotation", kPi / 2}, {"scale", {2, 3}}}), vec3(3, 0, 0));
    expectVec3(uv({{"rotation", kPi / 2}, {"scale", {2, 3}}, {"offset", {0.5, 0.25}}}),
               vec3(3.5f, 0.25f, 0));
}

TEST(TextureTransform, MayNameOtherCoordinates) {
    GltfFile file = textured();
    Json& texture = file.json["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"];
    texture["extensions"]["KHR_texture_transform"]["texCoord"] = 1;
    EXPECT_EQ(file.load().materials[0].textures[shared::TEXTURE_BASE_COLOR].uv_set, 1);
}

TEST(TextureSampler, NearestWhereMagnifiedIsNearest) {
    GltfFile file = textured();
    EXPECT_FALSE(file.load().textures[0].nearest);
    file.json["samplers"][0]["magFilter"] = 9728;
    const Scene scene = file.load();
    EXPECT_TRUE(scene.textures[0].nearest);
    EXPECT_EQ(scene.warnings.size(), 2u) << "none but of the camera and the sun";
}

TEST(VertexColors, MultiplyTheBaseColorOfEveryForm) {
    const auto base_color = [](int accessor_of_form) {
        GltfFile file = oneTriangle();
        Json& attributes = file.json["meshes"][0]["primitives"][0]["attributes"];
        const int accessor =
            accessor_of_form == 0
                ? file.addAccessor<float>({0.2f, 0.4f, 0.6f, 0, 0, 0, 1, 1, 1}, kFloat, "VEC3", 3)
            : accessor_of_form == 1
                ? file.addAccessor<float>({0.2f, 0.4f, 0.6f, 0.5f, 0, 0, 0, 0, 1, 1, 1, 1}, kFloat,
                                          "VEC4", 4)
            : accessor_of_form == 2
                ? file.addAccessor<uint8_t>({51, 102, 153, 0, 0, 0, 0, 0, 255, 255, 255, 0},
                                            kUnsignedByte, "VEC4", 4)
                : file.addAccessor<uint16_t>(
                      {13107, 26214, 39321, 0, 0, 0, 0, 0, 65535, 65535, 65535, 0}, kUnsignedShort,
                      "VEC4", 4);
        file.json["accessors"][static_cast<size_t>(accessor)]["normalized"] = accessor_of_form > 1;
        attributes["COLOR_0"] = accessor;
        file.json["materials"] =
            Json::array({{{"pbrMetallicRoughness", {{"baseColorFactor", {0.5, 1, 1, 1}}}}}});
        file.json["meshes"][0]["primitives"][0]["material"] = 0;
        return atCorner(file.load(), 0).base_color;
    };
    for (int form = 0; form < 4; ++form) {
        expectVec3(base_color(form), vec3(0.1f, 0.4f, 0.6f), std::to_string(form));
    }
}

TEST(VertexColors, OutOfRangeAreClampedAndSaid) {
    GltfFile file = oneTriangle();
    file.json["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] =
        file.addAccessor<float>({2, -1, std::nanf(""), 0, 0, 0, 1, 1, 1}, kFloat, "VEC3", 3);
    const Scene scene = file.load();
    EXPECT_EQ(scene.colors[0], vec4(1, 0, 0, 1));
    EXPECT_TRUE(warnsOf(scene, "vertex colour out of range"));
}

// Its colour, with texture and vertices, is what it emits, and nothing is scattered.
TEST(UnlitMaterial, EmitsItsColor) {
    GltfFile file = textured();
    Json& material = file.json["materials"][0];
    material["pbrMetallicRoughness"]["baseColorFactor"] = {0.5, 1, 1, 1};
    material["emissiveFactor"] = {9, 9, 9};
    material["extensions"]["KHR_materials_unlit"] = Json::object();
    file.json["extensionsUsed"] = {"KHR_materials_unlit"};
    Json& primitive = file.json["meshes"][0]["primitives"][0];
    primitive["attributes"]["TEXCOORD_0"] =
        file.addAccessor<float>({1, 0, 1, 0, 1, 0}, kFloat, "VEC2", 2);
    primitive["attributes"]["COLOR_0"] =
        file.addAccessor<float>({1, 0.5f, 1, 0, 0, 0, 1, 1, 1}, kFloat, "VEC3", 3);
    const Scene scene = file.load();
    const MaterialParams at = atCorner(scene, 0);
    expectVec3(at.emission, vec3(0.5f, 0.5f, 1.0f));
    expectVec3(at.base_color, vec3(0.0f));
    EXPECT_EQ(at.specular, 0.0f);
    EXPECT_EQ(at.metallic, 0.0f);
    EXPECT_TRUE(scene.lights.empty()) << "no sun is needed to see it";
    EXPECT_FALSE(warnsOf(scene, "KHR_materials_unlit"));
}

}  // namespace
}  // namespace sheen
