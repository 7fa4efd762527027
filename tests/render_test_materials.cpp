// What varies over a surface is seen alike by the camera, by the lights' pass, by records and by
// the reference.
#include <gtest/gtest.h>

#include "metrics/compare.h"
#include "reference/light.h"
#include "test_reference.h"
#include "test_render.h"

namespace sheen {
namespace {

constexpr int kSize = 32;

Comparison compareLayer(const Frame& test, const Frame& truth, Image<vec3> Frame::*layer,
                        const Image<vec3>* variance = nullptr) {
    return compareImages({.test = test.*layer,
                          .reference = truth.*layer,
                          .reference_variance = variance,
                          .test_primitive = &test.primitive,
                          .reference_primitive = &truth.primitive});
}

// A room with a point light whose floor has coloured tiles by its second coordinates, whose back
// wall has colours of vertices and whose left wall is a screen that emits in its upper half.
Scene variedRoom(const vec3& emission) {
    Scene scene;
    const uint32_t white = addMaterial(scene, diffuseParams(vec3(0.7f)));
    const uint32_t tiles = addMaterial(scene, glossyParams(vec3(1.0f), 1.0f, 1.0f));
    const uint32_t screen = addMaterial(scene, diffuseParams(vec3(0.1f), emission));
    addBox(scene, vec3(-1), vec3(1), {screen, white, tiles, white, white, white}, true);
    scene.lights.push_back(pointLight(vec3(0.3f, 0.4f, 0.4f), vec3(1.0f)));
    scene.cameras.push_back(lookAt(vec3(0.5f, 0.1f, 0.95f), vec3(-0.3f, -0.3f, -0.5f)));

    scene.second_uvs.assign(scene.positions.size(), vec2(0.0f));
    scene.colors.assign(scene.positions.size(), vec4(1.0f));
    for (size_t i = 0; i < scene.positions.size(); ++i) {
        const vec3& p = scene.positions[i];
        scene.uvs[i] = vec2(p.z, p.y);
        scene.second_uvs[i] = vec2(p.x, p.z);
        if (scene.normals[i].z > 0.5f) {
            scene.colors[i] = vec4(0.5f + 0.5f * p, 1.0f);
        }
    }
    const auto use = [&](uint32_t material, int what, int texture) -> TextureUse& {
        TextureUse& result = scene.materials[material].textures[static_cast<size_t>(what)];
        result.texture = texture;
        return result;
    };
    const std::vector<vec3> colors = {vec3(0.8f, 0.2f, 0.1f), vec3(0.2f, 0.7f, 0.3f),
                                      vec3(0.3f, 0.3f, 0.8f), vec3(0.9f, 0.8f, 0.2f)};
    TextureUse& color = use(tiles, shared::TEXTURE_BASE_COLOR, addTexture(scene, 2, 2, colors));
    color.uv_set = 1;
    color.transform = {.row_u = {0.6f, 0.8f}, .row_v = {-0.8f, 0.6f}, .offset = {0.1f, 0.3f}};
    // Green: roughness, blue: metallic.
    use(tiles, shared::TEXTURE_METALLIC_ROUGHNESS,
        addTexture(scene, 2, 1, {vec3(0, 0.8f, 0.0f), vec3(0, 0.6f, 0.5f)}))
        .uv_set = 1;
    use(screen, shared::TEXTURE_EMISSION,
        addTexture(scene, 1, 2, {vec3(0.0f), vec3(1.0f, 0.8f, 0.5f)}, shared::WRAP_CLAMP))
        .transform.row_v = {0.0f, 0.5f};
    scene.materials[screen].textures[shared::TEXTURE_EMISSION].transform.offset = {0.0f, 0.5f};
    scene.textures.back().nearest = true;
    return scene;
}

ReferenceResult reference(const Scene& scene) {
    return renderReference(scene, smallParams(scene, kSize, 1024));
}

// The greatest difference of a channel over pixels that see one triangle in both.
float worstDifference(const Frame& a, const Frame& b, Image<vec3> Frame::*layer) {
    float worst = 0.0f;
    for (size_t i = 0; i < a.primitive.pixels.size(); ++i) {
        if (a.primitive.pixels[i] == b.primitive.pixels[i]) {
            worst = std::max(worst, maxAbs((a.*layer).pixels[i] - (b.*layer).pixels[i]));
        }
    }
    return worst;
}

TEST(VariedMaterials, CameraAndReferenceSeeOneSurface) {
    const Scene scene = variedRoom(vec3(0.3f));
    const Frame truth = firstHits(scene, kSize, kSize);
    RenderParams params = smallRender(kSize, kSize);
    const Frame frame = renderFrame(scene, params).frame;
    EXPECT_LT(worstDifference(frame, truth, &Frame::albedo), 1e-3f);
    EXPECT_LT(worstDifference(frame, truth, &Frame::emission), 1e-5f);
    float brightest = 0.0f;
    for (const vec3& emission : frame.emission.pixels) {
        brightest = std::max(brightest, emission.x);
    }
    EXPECT_NEAR(brightest, 0.3f, 1e-4f);
}

// By rays at a pixel's middle, and in the shaders of the raster road, whose textures are halves.
TEST(VariedMaterials, AreLitAsByTheReference) {
    const Scene scene = variedRoom(vec3(0.0f));
    const ReferenceResult truth = reference(scene);
    for (GatherRoad road : kRoads) {
        const RenderResult result =
            renderFrame(scene, smallRender(kSize, kSize, Method::kRadiance, road));
        const Frame& frame = result.frame;
        const Comparison direct = compareLayer(frame, truth.frame, &Frame::direct);
        const Comparison indirect =
            compareLayer(frame, truth.frame, &Frame::indirect, &truth.frame.indirect_variance);
        EXPECT_LT(direct.rel_rmse, 0.02) << nameOf(road);
        EXPECT_LT(indirect.rel_rmse, 0.04) << nameOf(road);
        EXPECT_LT(std::abs(indirect.bias), 0.015) << nameOf(road);
    }
}

// A room seen from outside, through a wall that faces inward; over its floor a screen half of which
// a mask leaves out.
Scene dollhouse() {
    Scene scene;
    const uint32_t white = addMaterial(scene, diffuseParams(vec3(0.7f)));
    const uint32_t red = addMaterial(scene, diffuseParams(vec3(0.7f, 0.1f, 0.1f)));
    const uint32_t screen = addMaterial(scene, diffuseParams(vec3(0.2f, 0.2f, 0.7f)));
    addBox(scene, vec3(-1), vec3(1), {red, white, white, white, white, white}, true);
    for (Material& material : scene.materials) {
        material.single_sided = true;
    }
    addQuad(scene, vec3(-0.6f, -0.2f, -0.6f), vec3(0, 0, 1.2f), vec3(1.2f, 0, 0), screen);
    for (size_t i = scene.positions.size() - 4; i < scene.positions.size(); ++i) {
        scene.uvs[i] = vec2(scene.positions[i].x < 0.0f ? 0.0f : 1.0f, 0.0f);
    }
    Material& holed = scene.materials[screen];
    holed.single_sided = false;
    holed.alpha_cutoff = 0.5f;
    holed.alpha_texture.texture =
        addTexture(scene, 2, 1, {vec3(1.0f), vec3(1.0f)}, shared::WRAP_CLAMP);
    scene.images.back().words[7] = 0;
    scene.lights.push_back(pointLight(vec3(0.3f, 0.7f, 0.2f), vec3(1.0f)));
    scene.cameras.push_back(lookAt(vec3(0.5f, 0.6f, 3.5f), vec3(0.0f, -0.2f, 0.0f)));
    return scene;
}

TEST(Coverage, CamerasPassBacksAndHolesAndRaysPassHoles) {
    const Scene scene = dollhouse();
    const ReferenceResult truth = reference(scene);
    const RenderResult result = renderFrame(scene, smallRender(kSize, kSize));
    const Frame& frame = result.frame;
    int same = 0;
    int inside = 0;
    for (size_t i = 0; i < frame.primitive.pixels.size(); ++i) {
        same += frame.primitive.pixels[i] == truth.frame.primitive.pixels[i] ? 1 : 0;
        inside += frame.primitive.pixels[i] != kNoPrimitive ? 1 : 0;
        if (frame.primitive.pixels[i] != kNoPrimitive) {
            EXPECT_LT(frame.position.pixels[i].z, 0.999f) << "the wall in front is not seen";
        }
    }
    EXPECT_GT(same, kSize * kSize - 10);
    EXPECT_GT(inside, kSize * kSize / 4);
    EXPECT_LT(compareLayer(frame, truth.frame, &Frame::direct).rel_rmse, 0.02);
    EXPECT_LT(
        compareLayer(frame, truth.frame, &Frame::indirect, &truth.frame.indirect_variance).rel_rmse,
        0.04);
    // Light comes through the hole onto the floor below it, and only there.
    const auto lit = [&](float x, float z) {
        const RayScene rays(scene);
        Counters counters;
        const vec3 down(0, -1, 0);
        const RayHit hit = rays.intersect(vec3(x, -0.5f, z), down);
        return directRadiance(rays, rays.surfaceAt(hit, -down), counters).x > 0.0f;
    };
    EXPECT_TRUE(lit(0.1f, 0.0f));
    EXPECT_FALSE(lit(-0.4f, 0.0f));
}

void addTangents(Scene& scene) {
    scene.tangents.assign(scene.positions.size(), vec4(0.0f));
    for (size_t i = 0; i < scene.positions.size(); ++i) {
        const vec3& n = scene.normals[i];
        scene.tangents[i] = vec4(std::abs(n.x) > 0.5f ? vec3(0, 1, 0) : vec3(1, 0, 0), 1.0f);
    }
}

TextureUse bumps(Scene& scene) {
    TextureUse use;
    use.texture = addTexture(scene, 2, 2,
                             {vec3(0.7f, 0.4f, 0.95f), vec3(0.3f, 0.6f, 0.95f),
                              vec3(0.5f, 0.5f, 1.0f), vec3(0.4f, 0.7f, 0.9f)});
    use.transform = {.row_u = {3, 0}, .row_v = {0, 3}, .offset = {0, 0}};
    return use;
}

// Direct light by the mapped normal, as the reference has it, and records as without the map.
TEST(NormalMaps, BendDirectLightAndNoRecord) {
    Scene scene = variedRoom(vec3(0.0f));
    const int flat_records = renderFrame(scene, smallRender(kSize, kSize)).stats.records;
    addTangents(scene);
    for (Material& material : scene.materials) {
        material.normal_texture = bumps(scene);
    }
    const Frame truth = firstHits(scene, kSize, kSize);
    for (GatherRoad road : kRoads) {
        const RenderResult result =
            renderFrame(scene, smallRender(kSize, kSize, Method::kRadiance, road));
        const Frame& frame = result.frame;
        EXPECT_LT(compareLayer(frame, truth, &Frame::direct).rel_rmse, 0.02) << nameOf(road);
        if (road == GatherRoad::kRays) {
            EXPECT_LT(result.stats.records, 13 * flat_records / 10);
        }
    }
}

// A coat with a normal map over a floor that has none.
TEST(NormalMaps, OfCoatsBendWhatTheCoatReflects) {
    Scene scene = variedRoom(vec3(0.0f));
    addTangents(scene);
    Material& floor = scene.materials[scene.materials_of[4]];
    floor.layers = {.coat = 1.0f, .coat_roughness = 0.3f};
    floor.coat_normal_texture = bumps(scene);
    const ReferenceResult truth = reference(scene);
    const Frame frame = renderFrame(scene, smallRender(kSize, kSize)).frame;
    const Comparison direct = compareLayer(frame, truth.frame, &Frame::direct);
    const Comparison indirect =
        compareLayer(frame, truth.frame, &Frame::indirect, &truth.frame.indirect_variance);
    EXPECT_LT(direct.rel_rmse, 0.02);
    EXPECT_LT(indirect.rel_rmse, 0.04);
    EXPECT_LT(std::abs(indirect.bias), 0.015);
}

}  // namespace
}  // namespace sheen
