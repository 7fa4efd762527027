// Texels that lie within something, and what lies beside them.
#include <gtest/gtest.h>

#include "bake/dilate.h"
#include "test_bake.h"

namespace sheen {
namespace {

// A floor of 2 x 2, a box on it, an even sky.
Scene boxOnFloor(bool with_bottom) {
    Scene scene;
    const uint32_t white = addMaterial(scene, diffuseParams(vec3(0.5f)));
    addQuad(scene, vec3(-1, 0, 1), vec3(2, 0, 0), vec3(0, 0, -2), white);
    addBox(scene, vec3(-0.33f, 0, -0.33f), vec3(0.33f, 0.5f, 0.33f), white, false);
    if (!with_bottom) {
        scene.triangles.erase(scene.triangles.begin() + 2 + 4, scene.triangles.begin() + 2 + 6);
        scene.materials_of.resize(scene.triangles.size());
    }
    addSky(scene, vec3(1.0f));
    return scene;
}

TEST(Buried, aBoxBuriesTheFloorBelowIt) {
    for (const bool with_bottom : {true, false}) {
        const Scene scene = boxOnFloor(with_bottom);
        const Bench bench(scene, 48);
        EXPECT_GT(bench.map.buried, 0);
        bench.forSeen([&](size_t i) {
            const vec3& p = bench.map.receivers.positions[i];
            const bool on_floor = bench.map.receivers.triangles[i] < 2;
            EXPECT_FALSE(on_floor && std::max(std::abs(p.x), std::abs(p.z)) < 0.3299f);
        });
    }
}

TEST(Buried, aRoomWithALightBuriesNothing) {
    // Its walls face outward: all that is in it sees their backs.
    Scene scene;
    const uint32_t white = addMaterial(scene, diffuseParams(vec3(0.5f)));
    addBox(scene, vec3(-1), vec3(1), white, false);
    addBox(scene, vec3(-0.2f), vec3(0.2f), white, false);
    scene.lights.push_back(pointLight(vec3(0.0f, 0.7f, 0.0f), vec3(1.0f)));
    const Bench bench(scene, 48);
    EXPECT_EQ(bench.map.buried, 0);
}

// Around what stands on it the floor is no darker than the least that its own texels get, nor are
// those filled up.
TEST(Buried, noDarkRimWhereABoxStands) {
    const Scene scene = boxOnFloor(true);
    const Bench bench(scene, 48);
    const Baked baked = bench.bake();
    float least = kInfinity;
    bench.forSeen([&](size_t i) {
        if (bench.map.receivers.triangles[i] < 2) {
            least = std::min(least, baked.frame.indirect.pixels[i].x);
        }
    });
    // At the foot of a wall half of the sky is hidden.
    EXPECT_GT(least, 0.3f * kPi);
    for (size_t i = 0; i < bench.map.triangles.pixels.size(); ++i) {
        if (bench.map.triangles.pixels[i] < 2) {
            EXPECT_GE(baked.frame.indirect.pixels[i].x, 0.999f * least);
        }
    }
}

// Two rooms and the wall between them, which is as thick as a texel, or half as thick as one, or of
// no thickness at all: light in one, none in the other.
class Wall : public testing::TestWithParam<float> {};

TEST_P(Wall, letsNoLightThrough) {
    const float half = GetParam();
    Scene scene;
    const uint32_t white = addMaterial(scene, diffuseParams(vec3(0.7f)));
    addBox(scene, vec3(-1, 0, -1), vec3(1, 1, 1), white, true);
    if (half > 0.0f) {
        addBox(scene, vec3(-half, 0, -1), vec3(half, 1, 1), white, false);
    } else {
        addQuad(scene, vec3(0, 0, 1), vec3(0, 0, -2), vec3(0, 1, 0), white);
    }
    scene.lights.push_back(pointLight(vec3(-0.5f, 0.5f, 0.0f), vec3(1.0f)));
    const Bench bench(scene, 64);
    // Light of many bounces is kept at elements (light/elements.h), of which a wall without any
    // thickness lets four thousandths pass.
    const Baked baked = bench.bake({.bounces = half > 0.0f ? kAllBounces : 1});
    double lit = 0.0;
    float dark = 0.0f;
    int count = 0;
    bench.forSeen([&](size_t i) {
        const vec3& p = bench.map.receivers.positions[i];
        const float light =
            luminance(baked.frame.indirect.pixels[i]) + luminance(baked.frame.direct.pixels[i]);
        // Ends of the wall touch the room's walls, and faces look into it.
        if (p.x > half + 1e-4f || (p.x == half && bench.map.receivers.outward[i].x > 0.5f)) {
            dark = std::max(dark, light);
        } else if (p.x < -half - 1e-4f) {
            lit += light;
            ++count;
        }
    });
    EXPECT_GT(lit / count, 0.5);
    EXPECT_LT(dark, 0.002f * static_cast<float>(lit) / static_cast<float>(count));
}

INSTANTIATE_TEST_SUITE_P(Thickness, Wall, testing::Values(0.0f, 0.03f, 0.06f));

TEST(Dilate, fillsAllFromWhatIsNearest) {
    const Scene scene = boxOnFloor(true);
    const Bench bench(scene, 48);
    Image<vec3> light(48, 48, vec3(-1.0f));
    bench.forSeen([&](size_t i) { light.pixels[i] = vec3(3.0f); });
    dilate(bench.map, light);
    for (const vec3& c : light.pixels) {
        EXPECT_FLOAT_EQ(c.x, 3.0f);
    }
}

}  // namespace
}  // namespace sheen
