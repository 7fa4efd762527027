// Light at points that are no pixels, by closed forms.
#include <cmath>
#include <limits>

#include "library_test.h"

namespace sheen {
namespace {

// A grid on the floor, seen from above.
Points grid(int side, float spacing) {
    Points points;
    points.width = spacing;
    for (int i = 0; i < side * side; ++i) {
        points.positions.insert(points.positions.end(),
                                {(i % side - 0.5 * (side - 1)) * spacing, 0.0,
                                 (i / side - 0.5 * (side - 1)) * spacing});
        points.normals.insert(points.normals.end(), {0.0f, 2.0f, 0.0f});
    }
    return points;
}

TEST(LibraryPoints, DirectLightIsThatOfClosedForms) {
    // At a slant of 60 degrees half of 2 lux arrive; from below nothing does.
    const Light sun = {.kind = SHEEN_DIRECTIONAL_LIGHT,
                       .direction = {std::sqrt(3.0f), -1, 0},
                       .intensity = {2, 4, 6}};
    Points points = grid(3, 0.5f);
    points.normals[1] = -1.0f;
    const Irradiance light =
        irradiance(Scene::fromArrays(floorBelow(sun), {{"environment", "none"}}), points);
    EXPECT_EQ(light.direct[0], 0.0f);
    for (size_t i = 1; i < 9; ++i) {
        EXPECT_NEAR(light.direct[3 * i], 1.0f, 1e-5f);
        EXPECT_NEAR(light.direct[3 * i + 1], 2.0f, 1e-5f);
        EXPECT_NEAR(light.direct[3 * i + 2], 3.0f, 1e-5f);
    }
    // I cos / d^2.
    const Scene scene = Scene::fromArrays(
        floorBelow({.position = {0, 2, 0}, .intensity = {8, 8, 8}}), {{"environment", "none"}});
    const Points of_lamp = grid(5, 0.5f);
    const Irradiance lamp = irradiance(scene, of_lamp);
    for (size_t i = 0; i < lamp.direct.size(); i += 3) {
        const double d2 = of_lamp.positions[i] * of_lamp.positions[i] + 4.0 +
                          of_lamp.positions[i + 2] * of_lamp.positions[i + 2];
        EXPECT_NEAR(lamp.direct[i], 8.0 * 2.0 / (d2 * std::sqrt(d2)), 1e-4);
    }
}

TEST(LibraryPoints, TheLightOfAnEvenSkyIsPiTimesItsRadiance) {
    Arrays arrays = floorBelow({});
    arrays.lights.clear();
    const Scene scene = Scene::fromArrays(arrays, {{"environment", {3.0, 1.0, 0.5}}});
    const Irradiance light = irradiance(scene, grid(4, 0.3f), {{"accuracy", 1.0}});
    for (size_t i = 0; i < light.indirect.size(); i += 3) {
        EXPECT_NEAR(light.indirect[i], 3.0f * kPi, 0.01f * 3.0f * kPi);
        EXPECT_NEAR(light.indirect[i + 2], 0.5f * kPi, 0.01f * 0.5f * kPi);
        EXPECT_EQ(light.direct[i], 0.0f);
    }
    const Irradiance again = irradiance(scene, grid(4, 0.3f), {{"accuracy", 1.0}, {"threads", 1}});
    EXPECT_EQ(again.indirect, light.indirect);
}

TEST(LibraryPoints, WhereNoSurfaceIsTheyAreNotNumbersAndAWarningTells) {
    const Scene scene = Scene::fromArrays(floorBelow({.position = {0, 2, 0}}));
    Points points = grid(2, 0.5f);
    points.positions[4] = 0.51;   // above its width
    points.positions[7] = 0.49;   // within it
    points.positions[9] = 100.0;  // beside the floor
    std::vector<std::string> warnings;
    const Irradiance light = irradiance(
        scene, points, {}, {.warning = [&](const std::string& what) { warnings.push_back(what); }});
    EXPECT_TRUE(std::isnan(light.direct[3]));
    EXPECT_TRUE(std::isnan(light.indirect[9]));
    EXPECT_TRUE(std::isfinite(light.indirect[0]));
    EXPECT_TRUE(std::isfinite(light.indirect[6]));
    ASSERT_EQ(warnings.size(), 1u);
    EXPECT_EQ(warnings[0],
              "points: 2 of 4 have no surface within their width, point 1 is the first: NaN there");
    EXPECT_TRUE(irradiance(scene, {.positions = {}, .normals = {}, .width = 1}).direct.empty());
}

TEST(LibraryPoints, BadOnesAreErrors) {
    const Scene scene = Scene::fromArrays(floorBelow({}));
    expectError(ErrorKind::usage, "points: their width is 0", [&] {
        irradiance(scene, {.positions = {0, 0, 0}, .normals = {0, 1, 0}});
    });
    expectError(ErrorKind::usage, "points: position or normal 0 is not finite", [&] {
        irradiance(scene, {.positions = {0, 0, 0}, .normals = {0, 0, 0}, .width = 1});
    });
    expectError(ErrorKind::usage, "points: position or normal 1 is not finite", [&] {
        irradiance(scene, {.positions = {0, 0, 0, 0, std::nan(""), 0},
                           .normals = {0, 1, 0, 0, 1, 0},
                           .width = 1});
    });
    expectError(ErrorKind::usage, "must have 3 numbers a position and a normal", [&] {
        irradiance(scene, {.positions = {0, 0, 0}, .normals = {}, .width = 1});
    });
    expectError(ErrorKind::usage, "option size: there is none of that name here", [&] {
        irradiance(scene, grid(1, 1.0f), {{"size", "4x4"}});
    });
}

}  // namespace
}  // namespace sheen
