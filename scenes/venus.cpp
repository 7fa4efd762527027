// A glossy statue in a room with coloured walls and a polished floor, seen from low down, so that
// much of the picture is gloss at grazing angles.
#include <cmath>

#include "scenes/all_scenes.h"
#include "scenes/shapes.h"
#include "scenes/statue.h"

namespace sheen::scenes {
namespace {

constexpr double kPlinthHeight = 0.42;
constexpr double kFloorAlpha = 0.25;
constexpr double kMarbleAlpha = 0.30;

// A square plinth with mouldings at foot and top.
Mesh plinth() {
    Mesh mesh;
    addLathe(mesh,
             {{0.46, 0.0},
              {0.46, 0.09},
              {0.44, 0.11},
              {0.425, 0.14},
              {0.40, 0.155},
              {0.385, 0.175},
              {0.385, kPlinthHeight - 0.13},
              {0.395, kPlinthHeight - 0.115},
              {0.415, kPlinthHeight - 0.095},
              {0.43, kPlinthHeight - 0.06},
              {0.43, kPlinthHeight}},
             4, true);
    const double r = 0.43;
    addQuad(mesh, {dvec3(-r, kPlinthHeight, r), dvec3(r, kPlinthHeight, r),
                   dvec3(r, kPlinthHeight, -r), dvec3(-r, kPlinthHeight, -r)});
    return mesh;
}

}  // namespace

// Long, since it lists all that the scene holds.
Model venusGlossy() {
    const dvec3 lower(-2.0, 0.0, -2.2);
    const dvec3 upper(1.9, 3.0, 3.5);
    Model model;
    const auto paint = [&](const char* name, const dvec3& color) {
        return model.add({.name = name, .base_color = color, .specular = 0.0});
    };
    const std::array<int, 6> wall_materials = {
        paint("terracotta wall", {0.62, 0.20, 0.11}),
        paint("teal wall", {0.10, 0.36, 0.40}),
        model.add({.name = "polished floor",
                   .base_color = dvec3(0.30, 0.28, 0.26),
                   .roughness = roughnessFromAlpha(kFloorAlpha),
                   .specular_color = 4.0}),
        paint("ceiling", {0.75, 0.74, 0.72}),
        paint("back wall", {0.68, 0.66, 0.60}),
        paint("front wall", {0.60, 0.60, 0.60})};
    const std::array<const char*, 6> names = {"left wall", "right wall", "floor",
                                              "ceiling",   "back wall",  "front wall"};
    const std::array<Mesh, 6> walls = roomWalls(lower, upper);
    for (size_t i = 0; i < 6; ++i) {
        model.add(names[i], walls[i], wall_materials[i]);
    }
    const int marble = model.add({.name = "glossy marble",
                                  .base_color = dvec3(0.74, 0.70, 0.63),
                                  .roughness = roughnessFromAlpha(kMarbleAlpha),
                                  .specular_color = 2.5});
    const int stone = model.add({.name = "plinth stone",
                                 .base_color = dvec3(0.42, 0.40, 0.38),
                                 .roughness = roughnessFromAlpha(kMarbleAlpha)});
    model.add("plinth", plinth(), stone);
    model.add("statue", statue(), marble, {placement(dvec3(0.0, kPlinthHeight, 0.0), 0.25)});

    model.lights.push_back({.name = "key",
                            .type = "spot",
                            .position = dvec3(1.6, 2.7, 1.8),
                            .target = dvec3(-0.5, 0.9, -0.6),
                            .color = dvec3(1.0, 0.94, 0.86),
                            .intensity = 11.0,
                            .inner_cone = 10.0 * kDegree,
                            .outer_cone = 36.0 * kDegree});
    model.lights.push_back({.name = "ceiling washer",
                            .type = "spot",
                            .position = dvec3(-1.4, 2.0, 1.6),
                            .target = dvec3(-1.7, 3.0, 0.4),
                            .color = dvec3(1.0, 0.97, 0.92),
                            .intensity = 30.0,
                            .inner_cone = 15.0 * kDegree,
                            .outer_cone = 60.0 * kDegree});
    model.cameras.push_back({.name = "low",
                             .position = dvec3(0.15, 0.75, 3.2),
                             .target = dvec3(-0.03, 1.0, 0.0),
                             .y_fov = 50.0 * kDegree});
    model.cameras.push_back({.name = "bust",
                             .position = dvec3(0.65, 1.95, 1.05),
                             .target = dvec3(0.0, 1.80, 0.0),
                             .y_fov = 38.0 * kDegree});
    model.cameras.push_back({.name = "folds",
                             .position = dvec3(0.55, 0.95, 1.4),
                             .target = dvec3(0.02, 0.85, 0.0),
                             .y_fov = 42.0 * kDegree});
    model.cameras.push_back({.name = "back",
                             .position = dvec3(-1.3, 1.5, -1.5),
                             .target = dvec3(0.0, 1.25, 0.0),
                             .y_fov = 62.0 * kDegree});
    return model;
}

}  // namespace sheen::scenes
