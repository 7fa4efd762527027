// The loader on values that are odd: each is mended and said, or refused in one line, and what is
// accepted is right.
#include <array>
#include <cmath>

#include "scene_test_gltf.h"

namespace sheen {
namespace {

// Loads, expecting an error of `code` that begins with the file and holds `part`.
void expectRefused(const std::string& path, ExitCode code, const std::string& part) {
    try {
        loadScene(path);
        ADD_FAILURE() << "loaded; expected an error about " << part;
    } catch (const Error& error) {
        const std::string message = error.what();
        EXPECT_EQ(error.code(), code) << message;
        EXPECT_EQ(message.rfind(path, 0), 0u) << message;
        EXPECT_NE(message.find(part), std::string::npos) << message;
    }
}

// A light at the origin that shines along -z, over the triangle.
GltfFile lit(const Json& light) {
    GltfFile file = oneTriangle();
    file.json["extensions"]["KHR_lights_punctual"]["lights"] = Json::array({light});
    file.json["nodes"].push_back({{"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}});
    return file;
}

GltfFile spot(double inner, double outer) {
    return lit({{"type", "spot"},
                {"intensity", 100},
                {"spot", {{"innerConeAngle", inner}, {"outerConeAngle", outer}}}});
}

// What a spot of 100 candela brings to a point 2 m away, `angle` off its axis.
float luxAt(const Scene& scene, double angle) {
    const vec3 p(0.0f, 2.0 * std::sin(angle), -2.0 * std::cos(angle));
    return shared::sampleLight(scene.lights.at(0), p).irradiance.x;
}

TEST(SceneValues, EqualConesAreAHardEdge) {
    const double outer = kPi / 6;
    const Scene scene = spot(outer, outer).load();
    EXPECT_TRUE(warnsOf(scene, "innerConeAngle is as large as outerConeAngle"));
    EXPECT_FLOAT_EQ(luxAt(scene, 0.0), 25.0f);
    EXPECT_FLOAT_EQ(luxAt(scene, 0.999 * outer), 25.0f);
    EXPECT_EQ(luxAt(scene, 1.001 * outer), 0.0f);
    // Rounded to floats the angles may even be a little inside out.
    EXPECT_TRUE(warnsOf(spot(outer + 1e-7, outer).load(), "as large as"));
    EXPECT_FALSE(warnsOf(spot(0.9 * outer, outer).load(), "as large as"));
}

TEST(SceneValues, NarrowConesShineInFullOnTheirAxis) {
    for (const double outer : {0.3, 0.03, 0.003}) {
        for (const double inner_share : {0.0, 0.5, 1.0}) {
            const Scene scene = spot(inner_share * outer, outer).load();
            EXPECT_NEAR(luxAt(scene, 0.0), 25.0f, 0.25f) << outer << " " << inner_share;
            EXPECT_EQ(luxAt(scene, 1.1 * outer), 0.0f) << outer << " " << inner_share;
        }
    }
    expectRefused(spot(0.0, 0.001).write(), ExitCode::kInput, "too narrow");
}

TEST(SceneValues, NegativeColorsCountAsNone) {
    const Scene scene =
        lit({{"type", "point"}, {"intensity", 3}, {"color", {1.0, -0.5, 0.5}}}).load();
    EXPECT_EQ(scene.lights.at(0).intensity, vec3(3.0f, 0.0f, 1.5f));
    EXPECT_TRUE(warnsOf(scene, "light 0: color -0.5 is negative"));

    GltfFile file = oneTriangle();
    file.json["materials"] =
        Json::array({{{"pbrMetallicRoughness", {{"baseColorFactor", {-1.0, 0.5, 0.5, 1.0}}}},
                      {"emissiveFactor", {0.0, -2.0, 0.0}}}});
    const Scene surfaces = file.load();
    EXPECT_EQ(surfaces.materials[0].params.base_color.x, 0.0f);
    EXPECT_EQ(surfaces.materials[0].params.emission.y, 0.0f);
    EXPECT_TRUE(warnsOf(surfaces, "baseColorFactor -1 is out of range"));
    EXPECT_TRUE(warnsOf(surfaces, "emission -2 is out of range"));
}

GltfFile withLastRow(const std::array<double, 4>& row) {
    GltfFile file = oneTriangle();
    file.json["nodes"][0]["matrix"] = {2, 0, 0, row[0], 0, 2, 0, row[1],
                                       0, 0, 2, row[2], 4, 6, 8, row[3]};
    return file;
}

TEST(SceneValues, MatricesThatEndInWAreDividedByIt) {
    const Scene scene = withLastRow({0, 0, 0, 2}).load();
    EXPECT_EQ(scene.positions[scene.triangles[0].x], vec3(2, 3, 4));
    EXPECT_EQ(scene.positions[scene.triangles[0].y], vec3(3, 3, 4));
    EXPECT_TRUE(warnsOf(scene, "node 0: the last element of its matrix is 2"));

    const Scene rounded = withLastRow({1e-8, 0, -1e-8, 1.0 + 1e-7}).load();
    EXPECT_EQ(rounded.positions[rounded.triangles[0].y], vec3(6, 6, 8));
    EXPECT_FALSE(warnsOf(rounded, "matrix"));
}

TEST(SceneValues, ProjectiveMatricesAreRefused) {
    expectRefused(withLastRow({0, 0, 0.1, 1}).write(), ExitCode::kInput, "projective");
    expectRefused(withLastRow({0, 0, 0, 0}).write(), ExitCode::kInput, "projective");
}

TEST(SceneValues, LightBeyondFloatsIsRefused) {
    const auto point = [](double intensity) {
        return lit({{"type", "point"}, {"intensity", intensity}});
    };
    expectRefused(point(1e30).write(), ExitCode::kInput, "light 0");
    expectRefused(point(1e-30).write(), ExitCode::kInput, "make them brighter");
    expectRefused(lit({{"type", "directional"}, {"intensity", 1e13}}).write(), ExitCode::kInput,
                  "brings 1e+13 lux");
    for (const double accepted : {1e-11, 1.0, 1e11}) {
        EXPECT_EQ(point(accepted).load().lights.at(0).intensity.x, static_cast<float>(accepted));
    }
    EXPECT_EQ(point(0.0).load().lights.size(), 1u) << "that is switched off, not dim";
    // What counts is what arrives: the sun as a point light, at its distance.
    GltfFile sun = point(3e27);
    sun.json["nodes"].back()["translation"] = {0, 0, 1.5e11};
    EXPECT_EQ(sun.load().lights.size(), 1u);
    // Beside a sound light a dim one is no harm.
    GltfFile two = point(1e-30);
    two.json["extensions"]["KHR_lights_punctual"]["lights"].push_back({{"type", "point"}});
    two.json["nodes"].push_back({{"extensions", {{"KHR_lights_punctual", {{"light", 1}}}}}});
    EXPECT_EQ(two.load().lights.size(), 2u);
}

// A square facing +z at height z, its corners at +-half.
void addSquare(GltfFile& file, float half, float z, int material) {
    file.addPrimitive({-half, -half, z, half, -half, z, half, half, z,  //
                       -half, -half, z, half, half, z, -half, half, z})["material"] = material;
}

// Two materials of different colours, and a third that looks like the second.
GltfFile painted() {
    GltfFile file;
    for (const auto& [name, red] : {std::pair{"floor", 0.2}, {"rug", 0.7}, {"copy", 0.7}}) {
        file.json["materials"].push_back(
            {{"name", name}, {"pbrMetallicRoughness", {{"baseColorFactor", {red, 0.5, 0.5, 1}}}}});
    }
    return file;
}

TEST(SceneValues, OfCoplanarSurfacesTheLaterIsInFront) {
    GltfFile file = painted();
    addSquare(file, 4.0f, 1.0f, 0);
    addSquare(file, 1.0f, 1.0f, 1);
    const Scene scene = file.load();
    EXPECT_TRUE(warnsOf(scene, "materials 'floor' and 'rug' lie in one plane"));
    for (size_t i = 0; i < scene.positions.size(); ++i) {
        const float above = scene.positions[i].z - 1.0f;
        EXPECT_EQ(above > 0.0f, i >= 6) << i;
        EXPECT_LT(above, 2e-4f) << i;
    }
}

TEST(SceneValues, CoplanarLayersAreStacked) {
    GltfFile file = painted();
    addSquare(file, 4.0f, 0.0f, 0);
    addSquare(file, 2.0f, 0.0f, 1);
    addSquare(file, 1.0f, 0.0f, 0);
    const Scene scene = file.load();
    EXPECT_GT(scene.positions[6].z, 0.0f);
    EXPECT_GT(scene.positions[12].z, 1.5f * scene.positions[6].z);
}

TEST(SceneValues, WhatOnlyTouchesStaysWhereItIs) {
    const auto expect_unmoved = [](const GltfFile& file, const char* what) {
        const Scene scene = file.load();
        EXPECT_FALSE(warnsOf(scene, "one plane")) << what;
        for (const vec3& p : scene.positions) {
            EXPECT_EQ(p.z, std::round(p.z)) << what;
        }
    };
    GltfFile apart = painted();
    addSquare(apart, 4.0f, 0.0f, 0);
    addSquare(apart, 1.0f, 1.0f, 1);
    expect_unmoved(apart, "planes apart");

    GltfFile alike = painted();
    addSquare(alike, 4.0f, 0.0f, 1);
    addSquare(alike, 1.0f, 0.0f, 2);
    expect_unmoved(alike, "materials that look alike");

    GltfFile beside = painted();
    addSquare(beside, 1.0f, 0.0f, 0);
    addSquare(beside, 1.0f, 0.0f, 1);
    beside.json["nodes"][1]["translation"] = {2, 0, 0};
    expect_unmoved(beside, "squares with a common edge");

    // As the bottom of a box that stands on a floor.
    GltfFile back_to_back = painted();
    addSquare(back_to_back, 4.0f, 0.0f, 0);
    addSquare(back_to_back, 1.0f, 0.0f, 1);
    back_to_back.json["nodes"][1]["scale"] = {1, 1, -1};
    expect_unmoved(back_to_back, "facing each other");
}

TEST(SceneValues, OnlyAreaThatIsMissedIsNoted) {
    GltfFile poles;
    poles.addPrimitive({0, 0, 0, 1, 0, 0, 0, 1, 0,    // sound
                        1, 1, 1, 1, 1, 1, 2, 0, 0,    // as at a sphere's pole
                        0, 0, 0, 1, 0, 0, 1, 0, 0});  //
    EXPECT_FALSE(warnsOf(poles.load(), "without area"));
    GltfFile line;
    line.addPrimitive({0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 2, 0, 0});
    EXPECT_TRUE(warnsOf(line.load(), "triangle without area left out"));
    GltfFile gone = oneTriangle();
    gone.json["nodes"][0]["scale"] = {0, 0, 0};
    EXPECT_TRUE(warnsOf(gone.load(), "is its node scaled to zero?"));
}

TEST(SceneMemory, FilesWithoutAnEndAreNotRead) {
    expectRefused("/dev/zero", ExitCode::kInput, "not a regular file");
    const std::string path = temporaryPath("sparse.glb");
    writeFile(path, "");
    std::filesystem::resize_file(path, uint64_t{1} << 33);  // takes no space on the disk
    expectRefused(path, ExitCode::kInput, "neither");
    writeFile(path, "glTF");
    std::filesystem::resize_file(path, uint64_t{1} << 33);
    expectRefused(path, ExitCode::kInput, "more than 4 GiB");
}

TEST(SceneMemory, SparseAccessorsOfNothingAreBounded) {
    GltfFile file = oneTriangle();
    Json& accessor = file.json["accessors"][0];
    accessor.erase("bufferView");
    accessor["count"] = 1 << 25;
    accessor["sparse"] = {
        {"count", 1},
        {"indices", {{"bufferView", file.addView<uint8_t>({1})}, {"componentType", kUnsignedByte}}},
        {"values", {{"bufferView", file.addView<float>({1, 2, 3})}}}};
    expectRefused(file.write(), ExitCode::kInput, "has 33554432 elements and no buffer view");
    accessor["count"] = 3;
    EXPECT_EQ(file.load().triangleCount(), 0) << "three corners, two of them one";
}

TEST(SceneMemory, ManyNodesOfOneMeshAreCountedFirst) {
    GltfFile file;
    Json& primitive = file.addPrimitive(kTriangle);
    constexpr size_t kIndices = 3 << 17;
    primitive["indices"] =
        file.addAccessor<uint8_t>(std::vector<uint8_t>(kIndices), kUnsignedByte, "SCALAR", 1);
    for (int i = 0; i < 20000; ++i) {
        file.json["nodes"].push_back({{"mesh", 0}});
    }
    expectRefused(file.write(), ExitCode::kEnvironment, "its meshes have 7864713216");
}

}  // namespace
}  // namespace sheen
