// Meshes that Draco compressed, and textures as WebP.
#include <draco/compression/encode.h>
#include <draco/mesh/triangle_soup_mesh_builder.h>
#include <webp/encode.h>

#include <algorithm>
#include <array>
#include <functional>
#include <limits>

#include "scene_test_gltf.h"

namespace sheen {
namespace {

constexpr const char* kDraco = "KHR_draco_mesh_compression";

// A fan of triangles about (0, 0, 0) in the plane z = 0, each corner of a colour of its own.
constexpr int kFan = 6;

vec3 onRim(int i) {
    const float angle = 2.0f * kPi * static_cast<float>(i) / kFan;
    return {std::cos(angle), std::sin(angle), 0.0f};
}

std::array<uint8_t, 4> colorAt(const vec3& p) {
    return {static_cast<uint8_t>(std::lround(100.0f + 100.0f * p.x)), 7, 200, 255};
}

std::vector<uint8_t> encodedFan() {
    draco::TriangleSoupMeshBuilder builder;
    builder.Start(kFan);
    const int positions =
        builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
    const int colors =
        builder.AddAttribute(draco::GeometryAttribute::COLOR, 4, draco::DT_UINT8, true);
    for (int i = 0; i < kFan; ++i) {
        const std::array<vec3, 3> corners = {vec3(0.0f), onRim(i), onRim((i + 1) % kFan)};
        const draco::FaceIndex face(static_cast<uint32_t>(i));
        builder.SetAttributeValuesForFace(positions, face, &corners[0], &corners[1], &corners[2]);
        const std::array<std::array<uint8_t, 4>, 3> c = {colorAt(corners[0]), colorAt(corners[1]),
                                                         colorAt(corners[2])};
        builder.SetAttributeValuesForFace(colors, face, &c[0], &c[1], &c[2]);
    }
    const std::unique_ptr<draco::Mesh> mesh = builder.Finalize();
    draco::Encoder encoder;
    encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, 16);
    draco::EncoderBuffer buffer;
    EXPECT_TRUE(encoder.EncodeMeshToBuffer(*mesh, &buffer).ok());
    const auto* bytes = reinterpret_cast<const uint8_t*>(buffer.data());
    return {bytes, bytes + buffer.size()};
}

// As exporters write it: accessors without a view, the compressed mesh beside them.
GltfFile compressedFan() {
    GltfFile file;
    const int view = file.addView(encodedFan());
    file.json["accessors"] =
        Json::array({{{"componentType", kFloat}, {"count", kFan + 1}, {"type", "VEC3"}},
                     {{"componentType", kUnsignedByte},
                      {"count", kFan + 1},
                      {"type", "VEC4"},
                      {"normalized", true}},
                     {{"componentType", kUnsignedShort}, {"count", 3 * kFan}, {"type", "SCALAR"}}});
    Json primitive = {{"attributes", {{"POSITION", 0}, {"COLOR_0", 1}}}, {"indices", 2}};
    primitive["extensions"][kDraco] = {{"bufferView", view},
                                       {"attributes", {{"POSITION", 0}, {"COLOR_0", 1}}}};
    file.json["meshes"] = Json::array({{{"primitives", Json::array({primitive})}}});
    file.json["nodes"] = Json::array({{{"mesh", 0}}});
    file.json["extensionsUsed"] = {kDraco};
    file.json["extensionsRequired"] = {kDraco};
    return file;
}

TEST(DracoCompression, IsDecoded) {
    const Scene scene = compressedFan().load();
    ASSERT_EQ(scene.triangleCount(), kFan);
    float area = 0.0f;
    for (const uvec3& t : scene.triangles) {
        const vec3 normal = glm::cross(scene.positions[t.y] - scene.positions[t.x],
                                       scene.positions[t.z] - scene.positions[t.x]);
        EXPECT_GT(normal.z, 0.0f) << "as it was wound";
        area += 0.5f * normal.z;
        for (int c = 0; c < 3; ++c) {
            const auto color = colorAt(scene.positions[t[c]]);
            EXPECT_NEAR(scene.colors.at(t[c]).x, static_cast<float>(color[0]) / 255.0f, 0.006f);
            EXPECT_NEAR(scene.colors.at(t[c]).y, 7.0f / 255.0f, 1e-6f);
        }
    }
    EXPECT_NEAR(area, 3.0f * std::sin(kPi / 3.0f), 1e-3f);
    EXPECT_FALSE(warnsOf(scene, "draco"));
    EXPECT_TRUE(std::any_of(scene.features.begin(), scene.features.end(), [](const auto& f) {
        return f.name == kDraco && f.treatment == "right";
    }));
}

TEST(DracoCompression, OfAFileThatHoldsTheMeshBesidesIsNotAsked) {
    GltfFile file = oneTriangle();
    file.json["meshes"][0]["primitives"][0]["extensions"][kDraco] = {
        {"bufferView", file.addView(std::vector<uint8_t>{1, 2, 3})}};
    EXPECT_EQ(file.load().triangleCount(), 1);
}

TEST(DracoCompression, ThatIsBrokenIsAnInputError) {
    const std::vector<std::function<void(GltfFile&)>> breakages = {
        [](GltfFile& f) { f.binary.at(20) ^= 0x55; }, [](GltfFile& f) { f.binary.at(0) = 'X'; },
        // Counts of a billion.
        [](GltfFile& f) { f.binary.replace(12, 5, "\xff\xff\xff\xff\x03"); },
        [](GltfFile& f) { f.binary.replace(11, 5, "\xff\xff\xff\xff\x03"); },
        [](GltfFile& f) { f.json["bufferViews"][0]["byteLength"] = 20; },
        [](GltfFile& f) { f.json["accessors"][0]["count"] = kFan; },
        [](GltfFile& f) { f.json["accessors"][0]["count"] = 1 << 30; },
        [](GltfFile& f) {
            f.json["meshes"][0]["primitives"][0]["extensions"][kDraco]["bufferView"] = 9;
        },
        [](GltfFile& f) {
            f.json["meshes"][0]["primitives"][0]["extensions"][kDraco]["attributes"]["POSITION"] =
                77;
        }};
    for (size_t i = 0; i < breakages.size(); ++i) {
        GltfFile file = compressedFan();
        breakages[i](file);
        try {
            file.load();
            ADD_FAILURE() << "breakage " << i << " loaded";
        } catch (const Error& error) {
            EXPECT_EQ(error.code(), ExitCode::kInput) << error.what();
        }
    }
}

// ---- WebP ---------------------------------------------------------------------------------------

TEST(WebpTexture, IsTakenBeforeTheOneForWhoDoesNotKnowIt) {
    GltfFile file = textured();
    const std::vector<uint8_t> texel = {51, 102, 255, 255};
    uint8_t* encoded = nullptr;
    const size_t size = WebPEncodeLosslessRGBA(texel.data(), 1, 1, 4, &encoded);
    const int view = file.addView(std::vector<uint8_t>(encoded, encoded + size));
    WebPFree(encoded);
    const int plain = addPicture(file, {1, 1, {{{0, 0, 0}}}});
    file.json["images"].push_back({{"bufferView", view}, {"mimeType", "image/webp"}});
    Json& texture = file.json["textures"][static_cast<size_t>(plain)];
    texture["extensions"]["EXT_texture_webp"]["source"] = file.json["images"].size() - 1;
    file.json["extensionsUsed"] = {"EXT_texture_webp"};
    Json& pbr = file.json["materials"][0]["pbrMetallicRoughness"];
    pbr["metallicFactor"] = 1;
    pbr["roughnessFactor"] = 1;
    pbr["metallicRoughnessTexture"]["index"] = plain;
    const Scene scene = file.load();
    EXPECT_NEAR(materialAt(scene, 0, vec3(1, 0, 0)).roughness, 0.4f, 1e-6f);
    EXPECT_NEAR(materialAt(scene, 0, vec3(1, 0, 0)).metallic, 1.0f, 1e-6f);
    EXPECT_FALSE(warnsOf(scene, "webp"));
}

}  // namespace
}  // namespace sheen
