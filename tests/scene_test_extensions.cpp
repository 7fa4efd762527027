// Extensions of materials and meshes, and meshes in their first pose.
#include <meshoptimizer.h>

#include <cmath>

#include "scene_test_gltf.h"

namespace sheen {
namespace {

Json& materialOf(GltfFile& file) { return file.json["materials"][0]; }

vec3 f0At(const Scene& scene) {
    return shared::makeBrdf(materialAt(scene, 0, vec3(1, 0, 0)), 1.0f, vec2(1.0f, 0.0f)).f0;
}

TEST(MaterialIor, IsTheReflectanceAtNormalIncidence) {
    GltfFile file = textured();
    materialOf(file)["pbrMetallicRoughness"]["metallicFactor"] = 0;
    EXPECT_NEAR(f0At(file.load()).x, 0.04f, 1e-6f);
    Json& extensions = materialOf(file)["extensions"];
    extensions["KHR_materials_ior"]["ior"] = 2.0;
    EXPECT_NEAR(f0At(file.load()).x, 1.0f / 9.0f, 1e-6f);
    extensions["KHR_materials_specular"] = {{"specularFactor", 0.5},
                                            {"specularColorFactor", {1, 0.25, 20}}};
    const vec3 f0 = f0At(file.load());
    EXPECT_NEAR(f0.x, 0.5f / 9.0f, 1e-6f);
    EXPECT_NEAR(f0.y, 0.125f / 9.0f, 1e-6f);
    EXPECT_NEAR(f0.z, 0.5f, 1e-6f) << "at most 1 before the factor";
    extensions.erase("KHR_materials_specular");
    extensions["KHR_materials_ior"]["ior"] = 0;
    EXPECT_NEAR(f0At(file.load()).x, 1.0f, 1e-6f) << "infinite";
}

TEST(MaterialSpecularGlossiness, IsADielectricOfThatColour) {
    GltfFile file = textured();
    Json& extension = materialOf(file)["extensions"]["KHR_materials_pbrSpecularGlossiness"];
    extension = {{"diffuseFactor", {0.5, 0.25, 1, 0.75}},
                 {"specularFactor", {0.9, 0.6, 0.3}},
                 {"glossinessFactor", 0.75}};
    const Scene scene = file.load();
    const MaterialParams at = materialAt(scene, 0, vec3(1, 0, 0));
    EXPECT_EQ(at.base_color, vec3(0.5f, 0.25f, 1.0f));
    EXPECT_NEAR(at.roughness, 0.25f, 1e-6f);
    EXPECT_EQ(at.metallic, 0.0f);
    EXPECT_EQ(scene.materials[0].alpha, 0.75f);
    EXPECT_NEAR(f0At(scene).y, 0.6f, 1e-6f);

    // Half of the gloss is left where a texture has white of alpha 1: all of it.
    extension["specularGlossinessTexture"]["index"] = addPicture(file, {1, 1, {{{255, 255, 255}}}});
    const Scene with_texture = file.load();
    EXPECT_NEAR(materialAt(with_texture, 0, vec3(1, 0, 0)).roughness, 0.25f, 0.5f / 255.0f);
    EXPECT_NEAR(f0At(with_texture).y, 0.6f, 1e-6f);
}

TEST(MaterialClearcoat, IsFactorsTimesTextures) {
    GltfFile file = textured();
    Json& extension = materialOf(file)["extensions"]["KHR_materials_clearcoat"];
    extension = {{"clearcoatFactor", 0.5}, {"clearcoatRoughnessFactor", 0.8}};
    extension["clearcoatTexture"]["index"] = addPicture(file, {1, 1, {{{51, 0, 0}}}});
    extension["clearcoatRoughnessTexture"]["index"] = addPicture(file, {1, 1, {{{0, 102, 0}}}});
    Scene scene = file.load();
    const Layers at = layersAt(scene, 0, vec3(1, 0, 0));
    EXPECT_NEAR(at.coat, 0.5f * 0.2f, 1e-6f);
    EXPECT_NEAR(at.coat_roughness, 0.8f * 0.4f, 1e-6f);
    materialOf(file)["extensions"]["KHR_materials_unlit"] = Json::object();
    scene = file.load();
    EXPECT_TRUE(layersAt(scene, 0, vec3(1, 0, 0)).none()) << "nothing lies on what is not lit";
}

TEST(MaterialSheen, IsSrgbColourAndRoughnessByAlpha) {
    GltfFile file = textured();
    Json& extension = materialOf(file)["extensions"]["KHR_materials_sheen"];
    extension = {{"sheenColorFactor", {1, 0.5, 0}}, {"sheenRoughnessFactor", 0.6}};
    const int picture = addPicture(file, {1, 1, {{{128, 255, 255}}}});
    extension["sheenColorTexture"]["index"] = picture;
    extension["sheenRoughnessTexture"]["index"] = picture;
    const Layers at = layersAt(file.load(), 0, vec3(1, 0, 0));
    EXPECT_NEAR(at.fibre_color.x, 0.2158605f, 1e-6f);
    EXPECT_NEAR(at.fibre_color.y, 0.5f, 1e-6f);
    EXPECT_EQ(at.fibre_color.z, 0.0f);
    EXPECT_NEAR(at.fibre_roughness, 0.6f, 1e-6f);
    extension["sheenColorFactor"] = {1, 1};
    EXPECT_THROW(file.load(), Error);
}

TEST(MaterialAnisotropy, WidensTheRoundLobe) {
    GltfFile file = textured();
    materialOf(file)["pbrMetallicRoughness"]["roughnessFactor"] = 0.5;
    const auto roughness = [&](double strength) {
        materialOf(file)["extensions"]["KHR_materials_anisotropy"]["anisotropyStrength"] = strength;
        return file.load().materials[0].params.roughness;
    };
    EXPECT_NEAR(roughness(0.0), 0.5f, 1e-6f);
    EXPECT_NEAR(roughness(1.0), std::sqrt(0.5f), 1e-6f) << "alpha 1/4 and 1, on average 1/2";
}

// Of light that comes at right angles.
vec3 passesAt(const Scene& scene) {
    return crossingAt(scene, 0, vec3(1, 0, 0), -geometricNormal(scene, 0)).passes;
}

// Glass of ior 1.5 reflects 4% of light at right angles and passes the rest in its colour, as much
// of it as it transmits; the colour's alpha has no say where the material is opaque.
TEST(MaterialTransmission, PassesLightInItsColour) {
    constexpr float kError = 0.002f;  // of the table of the lobe's albedo
    GltfFile file = textured();
    materialOf(file)["pbrMetallicRoughness"] = {
        {"metallicFactor", 0}, {"roughnessFactor", 0}, {"baseColorFactor", {0.25, 0.5, 1, 0.1}}};
    Json& transmission = materialOf(file)["extensions"]["KHR_materials_transmission"];
    transmission["transmissionFactor"] = 1.0;
    const vec3 clear = passesAt(file.load());
    const vec3 color(0.25f, 0.5f, 1.0f);
    EXPECT_LT(maxAbs(clear - 0.96f * color), kError);
    EXPECT_EQ(coverageAt(file.load(), 0, vec3(1, 0, 0)), 1.0f);
    EXPECT_FALSE(warnsOf(file.load(), "transmission"));

    transmission["transmissionTexture"]["index"] = addPicture(file, {1, 1, {{{51, 255, 255}}}});
    const Scene milk = file.load();
    EXPECT_LT(maxAbs(passesAt(milk) - 0.2f * clear), kError);
    const MaterialParams at = materialAt(milk, 0, vec3(1, 0, 0));
    EXPECT_NEAR(shared::makeBrdf(at, 1.0f, vec2(0.0f)).diffuse.z, 0.8f, 1e-6f);
    transmission.erase("transmissionTexture");

    materialOf(file)["alphaMode"] = "BLEND";
    EXPECT_LT(maxAbs(passesAt(file.load()) - (0.9f + 0.1f * clear)), kError);
    materialOf(file)["alphaMode"] = "OPAQUE";
    materialOf(file)["pbrMetallicRoughness"]["metallicFactor"] = 1;
    EXPECT_EQ(passesAt(file.load()), vec3(0.0f)) << "no metal does";
    materialOf(file)["pbrMetallicRoughness"]["metallicFactor"] = 0;
    materialOf(file)["extensions"]["KHR_materials_unlit"] = Json::object();
    EXPECT_EQ(passesAt(file.load()), vec3(0.0f)) << "nothing is unlit and lit from behind";
}

// After the attenuation's distance its colour is left, of bodies alone.
TEST(MaterialVolume, AbsorbsByItsColourOverItsDistance) {
    GltfFile file = textured();
    materialOf(file)["pbrMetallicRoughness"]["metallicFactor"] = 0;
    materialOf(file)["extensions"]["KHR_materials_transmission"]["transmissionFactor"] = 1.0;
    Json& volume = materialOf(file)["extensions"]["KHR_materials_volume"];
    volume = {{"attenuationColor", {1.0, 0.5, 0.0}}, {"attenuationDistance", 0.25}};
    const auto absorption = [&] { return file.load().materials[0].absorption; };
    EXPECT_EQ(absorption(), vec3(0.0f)) << "a sheet";
    volume["thicknessFactor"] = 2.0;
    EXPECT_NEAR(absorption().x, 0.0f, 1e-6f);
    EXPECT_NEAR(absorption().y, std::log(2.0f) / 0.25f, 1e-5f);
    EXPECT_LT(std::exp(-0.25f * absorption().z), 2e-6f);
    EXPECT_FALSE(warnsOf(file.load(), "volume"));
    volume.erase("attenuationDistance");
    EXPECT_EQ(absorption(), vec3(0.0f)) << "never";
    materialOf(file)["extensions"].erase("KHR_materials_transmission");
    volume["attenuationDistance"] = 0.25;
    EXPECT_EQ(absorption(), vec3(0.0f)) << "opaque";
}

// A body bends light by its index, a sheet does not; and each of its two surfaces colours what
// passes by the root of the colour.
TEST(MaterialVolume, MakesABodyOfItsIndex) {
    constexpr float kError = 0.01f;  // of the table of lobes' albedos
    GltfFile file = textured();
    Json& pbr = materialOf(file)["pbrMetallicRoughness"];
    pbr = {
        {"baseColorFactor", {1.0, 0.25, 0.0, 1.0}}, {"metallicFactor", 0}, {"roughnessFactor", 0}};
    Json& extensions = materialOf(file)["extensions"];
    extensions["KHR_materials_transmission"]["transmissionFactor"] = 1.0;
    const auto material = [&] { return file.load().materials[0]; };
    EXPECT_FALSE(material().bounds()) << "a sheet";
    extensions["KHR_materials_volume"]["thicknessFactor"] = 0.5;
    EXPECT_EQ(material().ior, 1.5f);
    const Scene scene = file.load();
    const vec3 n_g = geometricNormal(scene, 0);
    const vec3 passes = crossingAt(scene, 0, vec3(0.5f, 0.25f, 0.25f), -n_g).passes;
    EXPECT_LT(maxAbs(passes - 0.96f * vec3(1.0f, 0.5f, 0.0f)), kError);
    extensions["KHR_materials_ior"]["ior"] = 1.33;
    EXPECT_EQ(material().ior, 1.33f);
    extensions["KHR_materials_ior"]["ior"] = 1.0;
    EXPECT_TRUE(material().bounds());
    EXPECT_FALSE(material().refracts());
    extensions["KHR_materials_ior"]["ior"] = 0.0;
    EXPECT_FALSE(material().refracts()) << "all is reflected";
}

TEST(MaterialVariants, AreChosenByName) {
    GltfFile file = oneTriangle();
    file.json["materials"] = Json::array({{{"name", "plain"}}, {{"name", "blue"}}});
    file.json["extensions"]["KHR_materials_variants"]["variants"] =
        Json::array({{{"name", "first"}}, {{"name", "second"}}});
    file.json["extensionsUsed"] = {"KHR_materials_variants"};
    Json& primitive = file.json["meshes"][0]["primitives"][0];
    primitive["material"] = 0;
    primitive["extensions"]["KHR_materials_variants"]["mappings"] =
        Json::array({{{"material", 1}, {"variants", {1}}}});
    const std::string path = file.write();
    EXPECT_EQ(loadScene(path).materials_of[0], 0u);
    EXPECT_EQ(loadScene(path, {.variant = "first"}).materials_of[0], 0u) << "not mapped";
    EXPECT_EQ(loadScene(path, {.variant = "second"}).materials_of[0], 1u);
    EXPECT_TRUE(loadScene(path).warnings.size() < 3u && !warnsOf(loadScene(path), "variants"));
    try {
        loadScene(path, {.variant = "third"});
        ADD_FAILURE() << "loaded";
    } catch (const Error& error) {
        EXPECT_EQ(error.code(), ExitCode::kUsage);
        EXPECT_NE(std::string(error.what()).find("first, second"), std::string::npos);
    }
}

// The triangle's positions and indices, compressed.
GltfFile compressed() {
    GltfFile file = oneTriangle();
    file.json["bufferViews"] = Json::array();
    file.binary.clear();
    const auto add = [&](const std::vector<uint8_t>& bytes, size_t count, size_t stride,
                         const char* mode) {
        const int view = file.addView(bytes);
        Json extension = file.json["bufferViews"][static_cast<size_t>(view)];
        extension.update({{"count", count}, {"byteStride", stride}, {"mode", mode}});
        file.json["bufferViews"][static_cast<size_t>(view)] = {
            {"buffer", 1},
            {"byteLength", count * stride},
            {"extensions", {{"EXT_meshopt_compression", extension}}}};
        return view;
    };
    std::vector<uint8_t> vertices(meshopt_encodeVertexBufferBound(3, 12));
    vertices.resize(
        meshopt_encodeVertexBuffer(vertices.data(), vertices.size(), kTriangle.data(), 3, 12));
    add(vertices, 3, 12, "ATTRIBUTES");
    const uint32_t triangle[] = {0, 1, 2};
    std::vector<uint8_t> indices(meshopt_encodeIndexBufferBound(3, 3));
    indices.resize(meshopt_encodeIndexBuffer(indices.data(), indices.size(), triangle, 3));
    file.json["accessors"].push_back({{"bufferView", add(indices, 3, 2, "TRIANGLES")},
                                      {"componentType", kUnsignedShort},
                                      {"count", 3},
                                      {"type", "SCALAR"}});
    file.json["meshes"][0]["primitives"][0]["indices"] = 1;
    file.json["buffers"] =
        Json::array({{{"byteLength", file.binary.size()}},
                     {{"byteLength", 42},
                      {"extensions", {{"EXT_meshopt_compression", {{"fallback", true}}}}}}});
    file.json["extensionsUsed"] = {"EXT_meshopt_compression"};
    file.json["extensionsRequired"] = {"EXT_meshopt_compression"};
    return file;
}

TEST(MeshoptCompression, IsDecoded) {
    const Scene scene = compressed().load();
    ASSERT_EQ(scene.triangleCount(), 1);
    EXPECT_EQ(scene.positions[scene.triangles[0].y], vec3(1, 0, 0));
    EXPECT_FALSE(warnsOf(scene, "meshopt"));
}

TEST(MeshoptCompression, ThatIsBrokenIsAnInputError) {
    const std::vector<std::function<void(Json&)>> breakages = {
        [](Json& e) { e["mode"] = "MAGIC"; },   [](Json& e) { e["filter"] = "OCTAHEDRAL"; },
        [](Json& e) { e["byteLength"] = 7; },   [](Json& e) { e["count"] = 1 << 30; },
        [](Json& e) { e["byteStride"] = 300; }, [](Json& e) { e["buffer"] = 4; },
        [](Json& e) { e["byteOffset"] = 1e8; }, [](Json& e) { e.erase("count"); }};
    for (size_t i = 0; i < breakages.size(); ++i) {
        GltfFile file = compressed();
        breakages[i](file.json["bufferViews"][0]["extensions"]["EXT_meshopt_compression"]);
        try {
            file.load();
            ADD_FAILURE() << "breakage " << i << " loaded";
        } catch (const Error& error) {
            EXPECT_EQ(error.code(), ExitCode::kInput) << error.what();
        }
    }
}

TEST(MorphTargets, AreAddedByTheStoredWeights) {
    GltfFile file = oneTriangle();
    const int up = file.addAccessor<float>({0, 0, 1, 0, 0, 2, 0, 0, 3}, kFloat, "VEC3", 3);
    file.json["meshes"][0]["primitives"][0]["targets"] =
        Json::array({{{"POSITION", up}}, {{"POSITION", up}}});
    EXPECT_EQ(file.load().bounds.upper.z, 0.0f) << "no weights";
    file.json["meshes"][0]["weights"] = {0.5, 0.25};
    EXPECT_NEAR(file.load().bounds.upper.z, 3 * 0.75f, 1e-6f);
    file.json["nodes"][0]["weights"] = {1.0, 0.0};
    EXPECT_NEAR(file.load().bounds.upper.z, 3.0f, 1e-6f) << "the node's own";
    file.json["accessors"][static_cast<size_t>(up)]["count"] = 1;
    EXPECT_THROW(file.load(), Error) << "of fewer vertices";
}

// The first vertex follows one joint, the second another, the third half of each.
TEST(Skins, StandWhereTheirJointsDo) {
    GltfFile file = oneTriangle();
    Json& attributes = file.json["meshes"][0]["primitives"][0]["attributes"];
    attributes["JOINTS_0"] =
        file.addAccessor<uint8_t>({0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0}, kUnsignedByte, "VEC4", 4);
    attributes["WEIGHTS_0"] =
        file.addAccessor<float>({1, 0, 0, 0, 1, 0, 0, 0, 0.5f, 0.5f, 0, 0}, kFloat, "VEC4", 4);
    std::vector<float> inverses(32, 0.0f);
    for (const size_t i : {0u, 5u, 10u, 15u}) {
        inverses[i] = inverses[16 + i] = 1.0f;
    }
    inverses[16 + 12] = -1.0f;  // the second joint was at x = 1 when it was bound
    file.json["skins"] = Json::array(
        {{{"joints", {1, 2}},
          {"inverseBindMatrices", file.addAccessor<float>(inverses, kFloat, "MAT4", 16)}}});
    file.json["nodes"][0]["skin"] = 0;
    file.json["nodes"][0]["translation"] = {50, 0, 0};  // has no say
    file.json["nodes"].push_back({{"translation", {0, 0, 4}}, {"children", {2}}});
    file.json["nodes"].push_back({{"translation", {1, 0, 2}}});
    const Scene scene = file.load();
    ASSERT_EQ(scene.triangleCount(), 1);
    const auto corner = [&](int c) { return scene.positions[scene.triangles[0][c]]; };
    EXPECT_EQ(corner(0), vec3(0, 0, 4));
    EXPECT_EQ(corner(1), vec3(1, 0, 6));
    EXPECT_EQ(corner(2), vec3(0, 1, 5));
    EXPECT_FALSE(warnsOf(scene, "skin"));

    file.json["skins"][0]["joints"] = {1};
    EXPECT_THROW(file.load(), Error) << "a joint that the skin has not";
}

TEST(Views, AreOnesOwnAndTheFirst) {
    GltfFile file = oneTriangle();
    file.json["cameras"] =
        Json::array({{{"type", "perspective"}, {"perspective", {{"yfov", 0.8}, {"znear", 0.1}}}}});
    file.json["nodes"].push_back({{"camera", 0}, {"translation", {0, 0, 3}}});
    const std::string path = file.write();
    LoadParams turned;
    turned.view.at = dvec3(4, 0, 0);
    turned.view.look_at = dvec3(4, 0, 5);
    const Scene scene = loadScene(path, turned);
    ASSERT_EQ(scene.cameras.size(), 2u);
    const Camera& own = scene.cameras[0];
    EXPECT_EQ(vec3(own.world_from_camera[3]), vec3(4, 0, 0));
    EXPECT_EQ(vec3(own.world_from_camera[2]), vec3(0, 0, -1)) << "back";
    EXPECT_EQ(vec3(own.world_from_camera[1]), vec3(0, 1, 0));
    EXPECT_EQ(own.y_fov, 0.8f);
    LoadParams wider;
    wider.view.y_fov = 1.5f;
    const Scene wide = loadScene(path, wider);
    EXPECT_EQ(wide.cameras[0].y_fov, 1.5f);
    EXPECT_EQ(wide.cameras[0].world_from_camera, wide.cameras[1].world_from_camera);
}

// All of a scene without cameras is in view, and fills it one way or the other.
TEST(Views, OfAFileWithoutCamerasFrameIt) {
    for (const vec3& size : {vec3(1, 1, 1), vec3(10, 1, 0), vec3(0.1f, 30, 2), vec3(0, 2, 50)}) {
        GltfFile file;
        file.addPrimitive({0, 0, 0, size.x, size.y, 0, 0, size.y, size.z});
        const Scene scene = file.load();
        const Camera& camera = scene.cameras.front();
        const mat4 camera_from_world = glm::inverse(camera.world_from_camera);
        vec2 lower(kInfinity), upper(-kInfinity);
        for (const vec3& p : scene.positions) {
            const vec3 seen(camera_from_world * vec4(p, 1.0f));
            ASSERT_LT(seen.z, 0.0f);
            const vec2 at = vec2(seen) / (-seen.z * std::tan(0.5f * camera.y_fov));
            lower = glm::min(lower, at);
            upper = glm::max(upper, at);
        }
        const float farthest = std::max(std::max(-lower.x, upper.x), std::max(-lower.y, upper.y));
        EXPECT_LE(farthest, 0.91f);
        EXPECT_GE(farthest, 0.89f);
    }
}

}  // namespace
}  // namespace sheen
