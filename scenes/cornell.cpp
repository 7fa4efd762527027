// The Cornell box: the published measurements of the real one, in metres, with its reflectances in
// linear sRGB, lit by a spot below the ceiling instead of the area light.
// Source: Cornell University Program of Computer Graphics, "Cornell Box Data".
#include "scenes/all_scenes.h"
#include "scenes/shapes.h"

namespace sheen::scenes {
namespace {

constexpr double kMillimetre = 0.001;
constexpr double kBackWallAlpha = 0.35;
constexpr double kBoxAlpha = 0.25;

using Corners = std::array<dvec3, 4>;

Mesh quadOf(const Corners& millimetres) {
    Corners corners = millimetres;
    for (dvec3& corner : corners) {
        corner *= kMillimetre;
    }
    Mesh mesh;
    addQuad(mesh, corners);
    return mesh;
}

// A block by its top face; the published blocks are upright.
Mesh blockOf(const Corners& top) {
    Mesh mesh = quadOf(top);
    for (size_t i = 0; i < 4; ++i) {
        const dvec3& a = top[i];
        const dvec3& b = top[(i + 1) % 4];
        mesh.append(quadOf({dvec3(a.x, 0.0, a.z), dvec3(b.x, 0.0, b.z), b, a}));
    }
    return mesh;
}

// The box with its white, red and green materials first.
Model box(const MaterialSpec& back_wall, const MaterialSpec& tall_block) {
    Model model;
    const auto paint = [&](const char* name, const dvec3& color) {
        return model.add({.name = name, .base_color = color, .specular = 0.0});
    };
    const int white = paint("white", {0.725, 0.71, 0.68});
    const int red = paint("red", {0.63, 0.065, 0.05});
    const int green = paint("green", {0.14, 0.45, 0.091});
    const int back = model.add(back_wall);
    const int tall = model.add(tall_block);

    model.add(
        "floor",
        quadOf({dvec3(552.8, 0, 0), dvec3(0, 0, 0), dvec3(0, 0, 559.2), dvec3(549.6, 0, 559.2)}),
        white);
    model.add("ceiling",
              quadOf({dvec3(556, 548.8, 0), dvec3(556, 548.8, 559.2), dvec3(0, 548.8, 559.2),
                      dvec3(0, 548.8, 0)}),
              white);
    model.add("back wall",
              quadOf({dvec3(549.6, 0, 559.2), dvec3(0, 0, 559.2), dvec3(0, 548.8, 559.2),
                      dvec3(556, 548.8, 559.2)}),
              back);
    model.add(
        "right wall",
        quadOf({dvec3(0, 0, 559.2), dvec3(0, 0, 0), dvec3(0, 548.8, 0), dvec3(0, 548.8, 559.2)}),
        green);
    model.add("left wall",
              quadOf({dvec3(552.8, 0, 0), dvec3(549.6, 0, 559.2), dvec3(556, 548.8, 559.2),
                      dvec3(556, 548.8, 0)}),
              red);
    model.add("short block",
              blockOf({dvec3(130, 165, 65), dvec3(82, 165, 225), dvec3(240, 165, 272),
                       dvec3(290, 165, 114)}),
              white);
    model.add("tall block",
              blockOf({dvec3(423, 330, 247), dvec3(265, 330, 296), dvec3(314, 330, 456),
                       dvec3(472, 330, 406)}),
              tall);
    model.lights.push_back({.name = "spot",
                            .type = "spot",
                            .position = dvec3(0.278, 0.50, 0.25),
                            .target = dvec3(0.278, 0.0, 0.22),
                            .intensity = 1.0,
                            .inner_cone = 15.0 * kDegree,
                            .outer_cone = 74.0 * kDegree});
    // The published place and direction; the lens a little longer, so that only the box is seen.
    model.cameras.push_back({.name = "front",
                             .position = dvec3(0.278, 0.273, -0.8),
                             .target = dvec3(0.278, 0.273, 0.0),
                             .y_fov = 37.5 * kDegree});
    model.cameras.push_back({.name = "close",
                             .position = dvec3(0.40, 0.20, 0.03),
                             .target = dvec3(0.25, 0.12, 0.40),
                             .y_fov = 60.0 * kDegree});
    return model;
}

}  // namespace

Model cornellDiffuse() {
    const MaterialSpec white = {
        .name = "white", .base_color = dvec3(0.725, 0.71, 0.68), .specular = 0.0};
    return box(white, white);
}

Model cornellGlossy() {
    return box({.name = "glossy wall",
                .base_color = dvec3(0.78, 0.77, 0.75),
                .metallic = 1.0,
                .roughness = roughnessFromAlpha(kBackWallAlpha)},
               {.name = "glossy block",
                .base_color = dvec3(0.90, 0.72, 0.45),
                .metallic = 1.0,
                .roughness = roughnessFromAlpha(kBoxAlpha)});
}

}  // namespace sheen::scenes
