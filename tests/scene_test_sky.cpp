// The sky of a file: EXT_lights_image_based.
#include "scene_test_gltf.h"

namespace sheen {
namespace {

constexpr const char* kExtension = "EXT_lights_image_based";
constexpr int kSize = 16;

// Faces as glTF orders them, each of a colour of its own; of the fourth, -y, the right half is
// black, of the last, -z, the left half.
GltfFile underCube() {
    GltfFile file = oneTriangle();
    const std::array<uint8_t, 3> colors[] = {{{255, 0, 0}},   {{0, 255, 0}},   {{0, 0, 255}},
                                             {{255, 255, 0}}, {{0, 255, 255}}, {{255, 0, 255}}};
    Json faces = Json::array();
    for (const auto& c : colors) {
        const std::array<uint8_t, 3> black{};
        const bool left = faces.size() == 5, right = faces.size() == 3;
        const auto& l = left ? black : c;
        const auto& r = right ? black : c;
        scenes::Picture face{kSize, kSize, {}};
        for (int i = 0; i < kSize * kSize; ++i) {
            face.pixels.push_back(i % kSize < kSize / 2 ? l : r);
        }
        addPicture(file, face);
        faces.push_back(file.json["images"].size() - 1);
    }
    file.json.erase("textures");
    file.json["extensionsUsed"] = {kExtension};
    file.json["extensions"][kExtension]["lights"] =
        Json::array({{{"intensity", 2.0},
                      {"specularImageSize", kSize},
                      {"specularImages", Json::array({faces})}}});
    file.json["scenes"][0]["nodes"] = {0};
    file.json["scenes"][0]["extensions"][kExtension] = {{"light", 0}};
    return file;
}

Json& lightOf(GltfFile& file) { return file.json["extensions"][kExtension]["lights"][0]; }

void expectColor(const Environment& sky, const vec3& direction, const vec3& color) {
    const vec3 seen = sky.radiance(glm::normalize(direction));
    for (int c = 0; c < 3; ++c) {
        EXPECT_NEAR(seen[c], 2.0f * color[c], 0.02f) << direction.x << direction.y << direction.z;
    }
}

TEST(FileSky, FacesLieWhereTheStandardSays) {
    const Scene scene = underCube().load();
    const Environment& sky = scene.environment;
    expectColor(sky, {1, 0.1f, 0.1f}, {1, 0, 0});
    expectColor(sky, {-1, 0.1f, 0.1f}, {0, 1, 0});
    expectColor(sky, {0.1f, 1, 0.1f}, {0, 0, 1});
    expectColor(sky, {0, 0.1f, 1}, {0, 1, 1});
    // As seen from inside: right of -z is +x; of -y, whose upper edge is at +z, it is -x.
    expectColor(sky, {0.7f, 0.1f, -1}, {1, 0, 1});
    expectColor(sky, {-0.7f, 0.1f, -1}, {0, 0, 0});
    expectColor(sky, {0.7f, -1, 0.1f}, {1, 1, 0});
    expectColor(sky, {-0.7f, -1, 0.1f}, {0, 0, 0});
    EXPECT_TRUE(scene.lights.empty()) << "no studio besides";
    EXPECT_TRUE(scene.warnings.empty() || !warnsOf(scene, kExtension));
}

TEST(FileSky, IsTurnedByItsRotation) {
    GltfFile file = underCube();
    const float half = std::sqrt(0.5f);  // a quarter turn about +y takes +z to +x
    lightOf(file)["rotation"] = {0.0f, half, 0.0f, half};
    expectColor(file.load().environment, {1, 0.1f, 0}, {0, 1, 1});
}

TEST(FileSky, AlphaDividesColours) {
    GltfFile file = underCube();
    const std::vector<uint8_t> png = {
        137, 80,  78, 71, 13, 10,  26,  10, 0,   0,   0,   13, 73,  72,  68,  82,  0, 0,
        0,   1,   0,  0,  0,  1,   8,   6,  0,   0,   0,   31, 21,  196, 137, 0,   0, 0,
        13,  73,  68, 65, 84, 120, 218, 99, 248, 223, 192, 96, 12,  0,   5,   180, 1, 179,
        45,  176, 48, 2,  0,  0,   0,   0,  73,  69,  78,  68, 174, 66,  96,  130};  // 1 x 1: 255,
                                                                                     // 128, 0 and
                                                                                     // an alpha of
                                                                                     // 51
    file.json["images"] =
        Json::array({{{"bufferView", file.addView(png)}, {"mimeType", "image/png"}}});
    lightOf(file)["specularImages"] = Json::array({{0, 0, 0, 0, 0, 0}});
    expectColor(file.load().environment, {1, 0, 0}, {5.0f, 5.0f * 0.2158605f, 0.0f});
}

TEST(FileSky, GivesWayToTheOneAskedFor) {
    const std::string path = underCube().write();
    LoadParams params;
    params.environment.source = "1,2,3";
    EXPECT_EQ(loadScene(path, params).environment.radiance(vec3(1, 0, 0)), vec3(1, 2, 3));
    params.environment.source = "none";
    EXPECT_TRUE(loadScene(path, params).environment.empty());
}

// What is wrong with it never keeps the file from loading: a studio lights it then.
TEST(FileSky, ABrokenOneIsLeftOutWithANote) {
    const auto expectNoted = [](const GltfFile& file, const char* part) {
        const Scene scene = file.load();
        EXPECT_TRUE(warnsOf(scene, part)) << part;
        EXPECT_EQ(scene.lights.size(), 1u) << part;
    };
    GltfFile file = underCube();
    lightOf(file)["specularImages"][0].erase(0);
    expectNoted(file, "six images");
    file = underCube();
    lightOf(file).erase("specularImages");
    expectNoted(file, "six images");
    file = underCube();
    lightOf(file)["specularImages"][0][3] = 17;
    expectNoted(file, "refers to image 17");
    file = underCube();
    addPicture(file, {1, 1, {{{1, 2, 3}}}});
    lightOf(file)["specularImages"][0][3] = 6;
    expectNoted(file, "face 3 has 1 x 1 texels");
    file = underCube();
    file.json["images"][2]["bufferView"] = file.addView<uint8_t>({1, 2, 3});
    expectNoted(file, "the sky shown without it");
    file = underCube();
    lightOf(file)["rotation"] = {0, 0, 0, 0};
    expectNoted(file, "rotation");
    file = underCube();
    lightOf(file)["intensity"] = -1;
    expectNoted(file, "intensity");
    file = underCube();
    file.json["scenes"][0]["extensions"][kExtension]["light"] = 1;
    expectNoted(file, "refers to light 1");
    file = underCube();
    file.json["extensions"][kExtension] = "what";
    expectNoted(file, "refers to light 0");
}

}  // namespace
}  // namespace sheen
