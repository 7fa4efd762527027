// Rays that take cells for the light on surfaces see what rays see that shade every hit.
#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "test_light.h"
#include "test_scenes.h"

namespace sheen {
namespace {

// What a ray of a hemisphere of about 3,500 stands for.
constexpr float kWide = 1.8e-3f;
// So little that no cell is smaller.
constexpr float kNarrow = 1e-12f;

// A box of edge 2 around a smaller one, with a light that the smaller one shades from much of it.
Scene roomWithBox() {
    Scene scene;
    const uint32_t walls = addMaterial(scene, diffuseParams(vec3(0.8f, 0.5f, 0.2f)));
    const uint32_t glossy = addMaterial(scene, glossyParams(vec3(0.6f), 0.0f, 0.4f));
    const uint32_t lamp = addMaterial(scene, diffuseParams(vec3(0.5f), vec3(0, 0, 2)));
    addBox(scene, vec3(-1), vec3(1), {walls, glossy, walls, lamp, walls, walls}, true);
    addBox(scene, vec3(-0.5f, -0.8f, -0.3f), vec3(0.1f, -0.2f, 0.4f), walls, false);
    scene.lights.push_back(pointLight(vec3(0.6f, 0.7f, 0.5f), vec3(1)));
    return scene;
}

struct Sight {
    std::vector<vec3> directions;
    std::vector<vec4> exact, by_cells;
};

// Random directions from `eye`, each ray standing for `solid_angle`.
Sight look(const Scene& scene, const vec3& eye, float solid_angle, int count = 4096) {
    const LitScene exact(scene);
    const LitByCells by_cells(scene);
    Sight sight;
    Random random(7);
    for (int i = 0; i < count; ++i) {
        sight.directions.push_back(random.direction());
    }
    const std::vector<float> solid_angles(sight.directions.size(), solid_angle);
    const Rays all{.origin = eye, .directions = sight.directions, .solid_angles = solid_angles};
    sight.exact.resize(sight.directions.size());
    sight.by_cells.resize(sight.directions.size());
    exact.light.cast(all, sight.exact.data());
    by_cells.light.cast(all, sight.by_cells.data());
    return sight;
}

double sum(const std::vector<vec4>& seen) {
    double total = 0.0;
    for (const vec4& s : seen) {
        total += s.x + s.y + s.z;
    }
    return total;
}

TEST(LightCells, TogetherSeeTheSameLight) {
    const Sight sight = look(roomWithBox(), vec3(0.3f, -0.1f, 0.2f), kWide);
    EXPECT_NEAR(sum(sight.by_cells) / sum(sight.exact), 1.0, 2e-3);
}

// A cell's light is that of its middle: it differs from the hit's by the cell's share of the way to
// the light, some percent here. A shadow's edge would differ by all of it.
TEST(LightCells, EachSeesNearlyTheSameLight) {
    const Sight sight = look(roomWithBox(), vec3(0.3f, -0.1f, 0.2f), kWide);
    int differ = 0;
    for (size_t i = 0; i < sight.exact.size(); ++i) {
        EXPECT_EQ(sight.by_cells[i].w, sight.exact[i].w);
        for (int c = 0; c < 3; ++c) {
            EXPECT_NEAR(sight.by_cells[i][c], sight.exact[i][c], 0.1f * sight.exact[i][c])
                << "ray " << i;
            differ += sight.by_cells[i][c] != sight.exact[i][c] ? 1 : 0;
        }
    }
    EXPECT_GT(differ, 1000);  // cells were taken
}

TEST(LightCells, NarrowRaysSeeTheLightOfTheirOwnHit) {
    const Sight sight = look(roomWithBox(), vec3(0.3f, -0.1f, 0.2f), kNarrow);
    EXPECT_EQ(sight.by_cells, sight.exact);
}

TEST(LightCells, BothSidesOfASurface) {
    Scene scene;
    addQuad(scene, vec3(-4, 0, 4), vec3(8, 0, 0), vec3(0, 0, -8),
            addMaterial(scene, diffuseParams(vec3(0.8f, 0.5f, 0.2f), vec3(0, 0, 0.1f))));
    scene.lights.push_back(pointLight(vec3(0, 3, 0), vec3(9)));
    scene.lights.push_back(directionalLight(vec3(0, 1, 0), vec3(0, 2, 0)));
    for (float height : {2.0f, -2.0f}) {
        const Sight sight = look(scene, vec3(0.3f, height, 0.1f), kWide);
        for (size_t i = 0; i < sight.exact.size(); ++i) {
            for (int c = 0; c < 3; ++c) {
                EXPECT_NEAR(sight.by_cells[i][c], sight.exact[i][c],
                            0.1f * sight.exact[i][c] + 1e-6f);
            }
        }
        EXPECT_NEAR(sum(sight.by_cells) / sum(sight.exact), 1.0, 2e-3);
    }
}

TEST(LightCells, MoreLightsThanACellHasBits) {
    Scene scene = roomWithBox();
    scene.lights.clear();
    Random random(3);
    for (int i = 0; i < 40; ++i) {
        scene.lights.push_back(pointLight(vec3(random.point(0.3f, 0.9f)), vec3(0.05f)));
    }
    const Sight sight = look(scene, vec3(0.3f, -0.1f, 0.2f), kWide, 512);
    EXPECT_NEAR(sum(sight.by_cells) / sum(sight.exact), 1.0, 2e-3);
}

// A fence of bars thinner than a cell: shadows that no corner of a cell may lie in.
TEST(LightCells, ThinShadowsAreSeen) {
    Scene scene;
    const uint32_t material = addMaterial(scene, diffuseParams(vec3(0.8f)));
    addQuad(scene, vec3(-4, 0, 4), vec3(8, 0, 0), vec3(0, 0, -8), material);
    const float cell = scene.bounds.size() / 256.0f;
    for (float x = -4.0f; x < 4.0f; x += 0.4f) {
        addQuad(scene, vec3(x, 0.5f, 4), vec3(0.7f * cell, 0, 0), vec3(0, 0, -8), material);
    }
    scene.lights.push_back(directionalLight(glm::normalize(vec3(0.3f, -1, 0.1f)), vec3(3)));
    const Sight sight = look(scene, vec3(0.13f, 0.3f, 0.2f), kWide);
    EXPECT_NEAR(sum(sight.by_cells) / sum(sight.exact), 1.0, 1e-2);
}

// A lamp so close to the floor that what it lights most is smaller than a cell.
TEST(LightCells, ALightCloserThanACell) {
    Scene scene;
    addQuad(scene, vec3(-4, 0, 4), vec3(8, 0, 0), vec3(0, 0, -8),
            addMaterial(scene, diffuseParams(vec3(0.8f))));
    for (float height : {0.002f, 0.01f, 0.1f}) {
        scene.lights = {pointLight(vec3(0.01f, height, 0.02f), vec3(1))};
        const Sight sight = look(scene, vec3(0.3f, 1.0f, 0.2f), kWide);
        for (size_t i = 0; i < sight.exact.size(); ++i) {
            EXPECT_NEAR(sight.by_cells[i].x, sight.exact[i].x, 0.25f * sight.exact[i].x);
        }
    }
}

TEST(LightCells, AnyScale) {
    const vec3 eye(0.3f, -0.1f, 0.2f);
    const Sight one = look(roomWithBox(), eye, kWide);
    for (float scale : {1.0f / 1024.0f, 8192.0f}) {
        const Sight other = look(scaled(roomWithBox(), scale), scale * eye, kWide);
        for (size_t i = 0; i < one.by_cells.size(); ++i) {
            for (int c = 0; c < 3; ++c) {
                EXPECT_NEAR(other.by_cells[i][c], one.by_cells[i][c], 1e-3f * one.by_cells[i][c]);
            }
        }
    }
}

TEST(LightCells, NoTrianglesAndNoLights) {
    EXPECT_EQ(sum(look(Scene{}, vec3(0.0f), kWide, 64).by_cells), 0.0);
    Scene dark = roomWithBox();
    dark.lights.clear();
    const Sight sight = look(dark, vec3(0.3f, -0.1f, 0.2f), kWide);
    EXPECT_EQ(sight.by_cells, sight.exact);
    EXPECT_GT(sum(sight.by_cells), 0.0);  // the lamp
}

}  // namespace
}  // namespace sheen
