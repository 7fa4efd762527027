// A scene is seen by its lightmap: what was baked is what is shown.
#include <gtest/gtest.h>

#include <cstring>
#include <fstream>
#include <functional>
#include <nlohmann/json.hpp>

#include "bake/dilate.h"
#include "bake/encode.h"
#include "scene/lightmap_file.h"
#include "scenes/all_scenes.h"
#include "test_bake.h"
#include "test_folder.h"
#include "test_glb.h"
#include "test_render.h"

namespace sheen {
namespace {

// A file with its light baked, and both as scenes.
struct Shown {
    TestFolder folder;
    std::string in = (folder.path() / "in.glb").string();
    std::string out = (folder.path() / "out.glb").string();
    Scene before;

    explicit Shown(
        const scenes::Model& model, const Edit& edit = [](Json&) {}) {
        const std::vector<uint8_t> bytes = scenes::encodeGlb(model);
        std::ofstream(in, std::ios::binary)
            << edited(std::string(bytes.begin(), bytes.end()), edit);
        before = loadScene(in, {.sources = true});
    }
    // `light`: of each texel; none: what a bake finds.
    Scene baked(int size, bool direct, const std::optional<vec3>& light = std::nullopt) const {
        const Bench bench(before, size);
        Image<vec3> irradiance(size, size, light.value_or(vec3(0.0f)));
        if (!light) {
            irradiance = beauty(bench.bake({.accuracy = 0.2f, .indirect_only = !direct}).frame);
        }
        return baked(bench, irradiance, direct);
    }
    Scene baked(const Bench& bench, const Image<vec3>& irradiance, bool direct) const {
        const EncodedLight encoded = encodeIrradiance(bench.map, irradiance);
        LightmapFile file = lightmapFileOf(in, bench.map.atlas);
        file.pngs = encoded.pngs;
        file.intensity = encoded.intensity;
        file.lights_baked = direct;
        writeLightmapped(out, before, file);
        return loadScene(out, {.lightmaps = true});
    }
    void editOutput(const Edit& edit) const {
        std::ifstream stream(out, std::ios::binary);
        const std::string bytes((std::istreambuf_iterator<char>(stream)), {});
        stream.close();
        std::ofstream(out, std::ios::binary) << edited(bytes, edit);
    }
};

RenderParams lightmapRender(int side) { return smallRender(side, side, Method::kLightmap); }

Image<vec3> sum(const Image<vec3>& a, const Image<vec3>& b) {
    Image<vec3> result = a;
    for (size_t i = 0; i < result.pixels.size(); ++i) {
        result.pixels[i] += b.pixels[i];
    }
    return result;
}

// Of 8 bits there are 255 steps to the brightest that is not clipped.
constexpr float kRounding = 0.5f / 255.0f;

TEST(ShownByLightmap, evenLightIsScatteredByTheAlbedo) {
    const Shown shown(scenes::cornellDiffuse());
    const vec3 light(0.5f, 1.0f, 2.0f);
    const Scene scene = shown.baked(64, true, light);
    ASSERT_TRUE(scene.lightmapped);
    EXPECT_TRUE(scene.lights.empty());  // no studio either
    EXPECT_TRUE(scene.environment.empty());
    const Frame frame = renderFrame(scene, lightmapRender(24)).frame;
    for (size_t i = 0; i < frame.albedo.pixels.size(); ++i) {
        const vec3 expected = frame.albedo.pixels[i] * light / kPi;
        const vec3 error = glm::abs(frame.indirect.pixels[i] - expected);
        EXPECT_LT(maxAbs(error), 2.0f * kRounding / kPi) << i;
        EXPECT_EQ(frame.direct.pixels[i], vec3(0.0f));
    }
}

// Light that tells where it is: no page is taken for another, nor any place on it.
TEST(ShownByLightmap, eachSurfaceByItsOwnPage) {
    const Shown shown(scenes::cornellDiffuse());
    const Bench bench(shown.before, {.size = 72, .texels_per_metre = 110.0f});
    ASSERT_GT(bench.map.atlas.pages, 2);
    Image<vec3> light(72, bench.map.atlas.height());
    const auto lightAt = [](const vec3& position) { return 1.0f + glm::abs(position); };
    bench.forSeen([&](size_t i) { light.pixels[i] = lightAt(bench.map.receivers.positions[i]); });
    dilate(bench.map, light);
    const Scene scene = shown.baked(bench, light, true);
    ASSERT_TRUE(scene.lightmapped);
    EXPECT_EQ(scene.triangles.size(), shown.before.triangles.size());
    const Frame frame = renderFrame(scene, lightmapRender(48)).frame;
    Image<vec3> expected = frame.indirect;
    for (size_t i = 0; i < expected.pixels.size(); ++i) {
        expected.pixels[i] = frame.albedo.pixels[i] * lightAt(frame.position.pixels[i]) / kPi;
    }
    EXPECT_LT(relativeRms(frame.indirect, expected), 0.01);
}

TEST(ShownByLightmap, agreesWithAnOrdinaryRender) {
    const Shown shown(scenes::cornellDiffuse());
    RenderParams params = smallRender(64, 64);
    params.bounces = kAllBounces;
    params.placement.accuracy = 0.2f;
    params.gather.size = 0;
    const Frame wanted = renderFrame(shown.before, params).frame;

    const Scene indirect = shown.baked(256, false);
    ASSERT_TRUE(indirect.lightmapped);
    EXPECT_FALSE(indirect.lamps_baked);
    const Frame by_indirect = renderFrame(indirect, lightmapRender(64)).frame;
    EXPECT_EQ(by_indirect.direct.pixels, wanted.direct.pixels);
    EXPECT_LT(relativeRms(by_indirect.indirect_diffuse, wanted.indirect_diffuse), 0.02);

    const Scene all = shown.baked(256, true);
    EXPECT_TRUE(all.lamps_baked);
    const Frame by_all = renderFrame(all, lightmapRender(64)).frame;
    EXPECT_LT(relativeRms(by_all.indirect_diffuse, sum(wanted.direct, wanted.indirect_diffuse)),
              0.1);
}

// A mirror shows what surfaces scatter of what their lightmaps hold, and the sky.
TEST(ShownByLightmap, mirrorsShowIt) {
    const Shown shown(scenes::cornellDiffuse(), [](Json& scene) {
        for (Json& material : scene["materials"]) {
            material["pbrMetallicRoughness"] = {{"baseColorFactor", {1, 1, 1, 1}},
                                                {"metallicFactor", 1},
                                                {"roughnessFactor", 0.05}};
            material.erase("extensions");
        }
    });
    shown.baked(64, true, vec3(2.0f));
    const std::string sky = std::to_string(2.0f / kPi);
    const Scene scene = loadScene(
        shown.out, {.environment = {.source = sky + "," + sky + "," + sky}, .lightmaps = true});
    const Frame frame = renderFrame(scene, lightmapRender(16)).frame;
    for (size_t i = 0; i < frame.albedo.pixels.size(); ++i) {
        if (frame.primitive.pixels[i] != kNoPrimitive) {
            EXPECT_NEAR(frame.indirect.pixels[i].y, 2.0f / kPi, 0.02f * 2.0f / kPi) << i;
        }
    }
}

// What a lamp sends is in the lightmap, unless that says that it is not: never twice.
TEST(ShownByLightmap, lampsAreSeenAndLightOnlyWhatTheyMust) {
    const Shown shown(scenes::cornellDiffuse(), [](Json& scene) {
        for (Json& node : scene["nodes"]) {
            node.erase("extensions");
        }
        scene["materials"][0]["emissiveFactor"] = {1, 1, 1};
    });
    ASSERT_TRUE(shown.before.lights.empty());
    for (const bool direct : {true, false}) {
        const Scene scene = shown.baked(64, direct, vec3(1.0f));
        const Frame frame = renderFrame(scene, lightmapRender(16)).frame;
        double sent = 0.0, emitted = 0.0;
        for (size_t i = 0; i < frame.direct.pixels.size(); ++i) {
            sent += frame.direct.pixels[i].x;
            emitted += frame.emission.pixels[i].x;
        }
        EXPECT_EQ(sent > 0.0, !direct);
        EXPECT_GT(emitted, 0.0);
    }
}

// A sky of one's own is seen, and lights nothing again.
TEST(ShownByLightmap, skiesAreSeenAlone) {
    const Shown shown(scenes::cornellDiffuse());
    shown.baked(64, true, vec3(1.0f));
    const Scene scene =
        loadScene(shown.out, {.environment = {.source = "5,5,5"}, .lightmaps = true});
    const Scene without = loadScene(shown.out, {.lightmaps = true});
    const Frame seen = renderFrame(scene, lightmapRender(24)).frame;
    const Frame dark = renderFrame(without, lightmapRender(24)).frame;
    EXPECT_EQ(seen.indirect.pixels, dark.indirect.pixels);
}

TEST(ShownByLightmap, coordinatesOfAnySetWillDo) {
    const Shown shown(scenes::cornellDiffuse());
    shown.baked(64, true, vec3(1.0f));
    shown.editOutput([](Json& scene) {
        for (Json& mesh : scene["meshes"]) {
            for (Json& primitive : mesh["primitives"]) {
                Json& attributes = primitive["attributes"];
                attributes["TEXCOORD_3"] = attributes["TEXCOORD_1"];
                attributes["TEXCOORD_2"] = attributes["TEXCOORD_1"];
            }
        }
        for (Json& material : scene["materials"]) {
            material["extensions"]["MOZ_lightmap"]["texCoord"] = 3;
        }
    });
    const Scene scene = loadScene(shown.out, {.lightmaps = true});
    ASSERT_TRUE(scene.lightmapped);
    EXPECT_EQ(scene.lightmap_uvs, scene.second_uvs);
}

TEST(ShownByLightmap, isIgnoredAloudWhereSomeSurfaceHasNone) {
    const auto said = [](const Scene& scene) {
        std::string all;
        for (const std::string& warning : scene.warnings) {
            all += warning + "\n";
        }
        return all;
    };
    const Shown shown(scenes::cornellDiffuse());
    shown.baked(64, true, vec3(1.0f));
    const Scene unwanted = loadScene(shown.out);
    EXPECT_FALSE(unwanted.lightmapped);
    EXPECT_NE(said(unwanted).find("--method lightmap"), std::string::npos) << said(unwanted);
    shown.editOutput(
        [](Json& scene) { scene["materials"][0]["extensions"].erase("MOZ_lightmap"); });
    const Scene lacking = loadScene(shown.out, {.lightmaps = true});
    EXPECT_FALSE(lacking.lightmapped);
    EXPECT_NE(said(lacking).find("has none"), std::string::npos) << said(lacking);
    EXPECT_THROW(renderFrame(lacking, lightmapRender(8)), Error);
    EXPECT_TRUE(lacking.lightmap_uvs.empty());
}

}  // namespace
}  // namespace sheen
