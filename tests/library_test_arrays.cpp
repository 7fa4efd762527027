// Scenes that are handed over as arrays.
#include <cmath>
#include <limits>

#include "library_test.h"

namespace sheen {
namespace {

// What the pixel in the middle shows of direct light; of an odd image, straight below the camera.
std::array<float, 3> inTheMiddle(const Arrays& scene) {
    const Frame frame = Session(Scene::fromArrays(scene, {{"environment", "none"}}))
                            .render({{"size", "25x25"}, {"aa", 1}, {"accuracy", 2}});
    const Layer direct = frame.layer("direct");
    return {direct.at(12, 12, 0), direct.at(12, 12, 1), direct.at(12, 12, 2)};
}

TEST(LibraryArrays, LightsOfAllKindsShineByTheirUnits) {
    // 2 lux straight below each.
    const float height = 4.0f;
    const float candela = 2.0f * height * height;
    const auto directional = inTheMiddle(floorBelow(
        {.kind = SHEEN_DIRECTIONAL_LIGHT, .direction = {0, -3, 0}, .intensity = {2, 2, 2}}));
    const auto point = inTheMiddle(
        floorBelow({.position = {0, height, 0}, .intensity = {candela, candela, candela}}));
    const auto spot = inTheMiddle(floorBelow({.kind = SHEEN_SPOT_LIGHT,
                                              .position = {0, height, 0},
                                              .direction = {0, -1, 0},
                                              .intensity = {candela, candela, candela},
                                              .inner_cone = 0.2f,
                                              .outer_cone = 0.4f}));
    for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(point[c], directional[c], 1e-4f * directional[c]);
        EXPECT_NEAR(spot[c], directional[c], 1e-4f * directional[c]);
    }
    // At normal incidence a dielectric of base colour b shows b / pi times what is not reflected,
    // and a lobe of at most a few percent of it.
    EXPECT_GT(directional[0], 0.93f * 2.0f * 0.5f / kPi);
    EXPECT_LT(directional[0], 1.15f * 2.0f * 0.5f / kPi);
    EXPECT_GT(directional[0], directional[1]);
    EXPECT_GT(directional[1], directional[2]);
    const auto away = inTheMiddle(floorBelow({.kind = SHEEN_SPOT_LIGHT,
                                              .position = {0, height, 0},
                                              .direction = {1, -1, 0},
                                              .intensity = {candela, candela, candela},
                                              .inner_cone = 0.2f,
                                              .outer_cone = 0.4f}));
    EXPECT_EQ(away[0], 0.0f);
}

TEST(LibraryArrays, CamerasSeeWhatTheyLookAt) {
    Arrays scene = floorBelow({.position = {0, 4, 0}, .intensity = {20, 20, 20}});
    scene.cameras.push_back({.name = "slanted", .position = {3, 4, 0}, .fov = 30.0f});
    const Session session(Scene::fromArrays(scene));
    const Options options = {{"size", "25x25"}, {"aa", 1}, {"layers", "all"}, {"accuracy", 2}};
    const Frame above = session.render(options);
    EXPECT_NEAR(above.layer("depth").at(12, 12), 3.0f, 1e-4f);
    // Its up direction, -z, is up in the image; +x is to the right.
    EXPECT_LT(above.layer("position").at(12, 0, 2), -0.5f);
    EXPECT_GT(above.layer("position").at(24, 12, 0), 0.5f);
    EXPECT_NEAR(above.layer("normal").at(12, 12, 1), 1.0f, 1e-6f);
    Options slanted = options;
    slanted.emplace_back("camera", "slanted");
    EXPECT_NEAR(session.render(slanted).layer("depth").at(12, 12), 5.0f, 1e-4f);
}

TEST(LibraryArrays, EmissionIsRadianceInNits) {
    Arrays scene = floorBelow({});
    scene.lights.clear();
    scene.materials[0].emission[0] = 3.0f;
    scene.materials[0].emission[1] = 0.5f;
    const Frame frame = Session(Scene::fromArrays(scene)).render(small({{"layers", "all"}}));
    EXPECT_NEAR(frame.layer("emission").at(12, 10, 0), 3.0f, 1e-6f);
    EXPECT_NEAR(frame.layer("emission").at(12, 10, 1), 0.5f, 1e-6f);
    EXPECT_EQ(frame.layer("emission").at(12, 10, 2), 0.0f);
}

TEST(LibraryArrays, ImagesMultiplyWhatTheyStandBeside) {
    // Left half red, right half half as bright in linear light, which sRGB has at 188.
    std::vector<std::uint8_t> texels;
    for (int x = 0; x < 16; ++x) {
        x < 8 ? texels.insert(texels.end(), {255, 0, 0, 255})
              : texels.insert(texels.end(), {188, 188, 188, 255});
    }
    const ImageView image = {16, 1, texels.data()};
    Arrays scene = floorBelow({.position = {0, 4, 0}, .intensity = {20, 20, 20}});
    scene.materials[0].base_color[0] = scene.materials[0].base_color[1] =
        scene.materials[0].base_color[2] = 1.0f;
    scene.materials[0].color_image = &image;
    scene.meshes[0].uvs = {0, 0, 0, 1, 1, 1, 1, 0};
    scene.cameras[0].fov = 100.0f;
    const Frame frame =
        Session(Scene::fromArrays(scene)).render({{"size", "25x25"}, {"aa", 1}, {"layers", "all"}});
    const Layer albedo = frame.layer("albedo");
    EXPECT_EQ(albedo.at(6, 12, 1), 0.0f);
    EXPECT_GT(albedo.at(6, 12, 0), 0.8f);
    EXPECT_NEAR(albedo.at(18, 12, 1) / albedo.at(6, 12, 0), 0.5f, 0.01f);
}

TEST(LibraryArrays, EmptyOnesAreEmptyScenes) {
    std::vector<std::string> warnings;
    const Listener listener{.warning = [&](const std::string& what) { warnings.push_back(what); }};
    const Scene scene = Scene::fromArrays({}, {}, listener);
    EXPECT_EQ(scene.triangleCount(), 0u);
    double lower[3], upper[3];
    EXPECT_FALSE(scene.bounds(lower, upper));
    EXPECT_FALSE(warnings.empty());
    EXPECT_EQ(Session(scene).render(small()).layer("alpha").at(3, 3), 0.0f);
    // Meshes of nothing are left out.
    Arrays arrays = floorBelow({});
    arrays.meshes.push_back({.name = "nothing", .positions = {}});
    EXPECT_EQ(Scene::fromArrays(arrays).triangleCount(), 2u);
    EXPECT_TRUE(Scene::fromArrays(arrays).bounds(lower, upper));
    EXPECT_EQ(lower[0], -5.0);
    EXPECT_EQ(upper[2], 5.0);
}

// What is done to a sound scene, and the line that says so.
struct Broken {
    const char* message;
    void (*how)(Arrays&);
};

TEST(LibraryArrays, BadOnesAreInputErrorsThatSayWhere) {
    const Broken all[] = {
        {"mesh 0 (floor): triangle 1 refers to vertex 4, of which there are 4",
         [](Arrays& a) { a.meshes[0].indices[4] = 4; }},
        {"mesh 0 (floor): number 2 of its positions is not finite",
         [](Arrays& a) { a.meshes[0].positions[2] = std::nanf(""); }},
        {"mesh 0 (floor): has material 1, of which there are 1",
         [](Arrays& a) { a.meshes[0].material = 1; }},
        {"mesh floor: arrays must hold 3 numbers", [](Arrays& a) { a.meshes[0].indices.clear(); }},
        {"mesh floor: arrays must hold 3 numbers", [](Arrays& a) { a.meshes[0].uvs = {0}; }},
        {"light 0: its intensity is negative", [](Arrays& a) { a.lights[0].intensity[1] = -1; }},
        {"light 0: its direction is zero",
         [](Arrays& a) {
             a.lights[0] = {.kind = SHEEN_DIRECTIONAL_LIGHT, .direction = {0, 0, 0}};
         }},
        {"light 0: its kind is 7", [](Arrays& a) { a.lights[0].kind = LightKind(7); }},
        {"material 0 (floor): its emission is negative",
         [](Arrays& a) { a.materials[0].emission[2] = -0.1f; }},
        {"material 0 (floor): number 1 of its metallic and roughness is not finite",
         [](Arrays& a) { a.materials[0].roughness = std::numeric_limits<float>::infinity(); }},
        {"camera 0 (above): its field of view is 180", [](Arrays& a) { a.cameras[0].fov = 180; }},
        {"camera 0 (above): looks at itself",
         [](Arrays& a) { a.cameras[0].look_at[1] = a.cameras[0].position[1]; }},
        {"camera 0 (above): looks at itself, or along its up direction", [](Arrays& a) {
             a.cameras[0].up[1] = 1;
             a.cameras[0].up[2] = 0;
         }}};
    for (const Broken& broken : all) {
        Arrays arrays = floorBelow({});
        broken.how(arrays);
        expectError(ErrorKind::input, broken.message, [&] { Scene::fromArrays(arrays); });
    }
    sheen_mesh mesh = {};
    const float positions[9] = {};
    mesh.vertex_count = 3;
    mesh.positions = positions;
    mesh.triangle_count = 2;
    mesh.material = -1;
    sheen_arrays c = {};
    c.mesh_count = 1;
    sheen_scene* scene = nullptr;
    sheen_error error;
    EXPECT_EQ(sheen_scene_from_arrays(&c, nullptr, 0, nullptr, &scene, &error), SHEEN_INPUT);
    EXPECT_STREQ(error.message, "arrays: meshes: NULL, but there should be 1");
    c.meshes = &mesh;
    EXPECT_EQ(sheen_scene_from_arrays(&c, nullptr, 0, nullptr, &scene, &error), SHEEN_INPUT);
    EXPECT_STREQ(error.message,
                 "arrays: mesh 0: has 3 vertices and no indices, where its 2 triangles need 6");
    const ImageView no_texels = {0, 3, nullptr};
    Arrays arrays = floorBelow({});
    arrays.materials[0].color_image = &no_texels;
    expectError(ErrorKind::input, "an image is NULL or not of 1..16384 texels a side",
                [&] { Scene::fromArrays(arrays); });
}

}  // namespace
}  // namespace sheen
