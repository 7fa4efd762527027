// A long gallery lit by luminous panels of its ceiling and, through two windows, by the sky: light
// of large and soft sources on a glossy floor, statues and pale walls. The sky is not in the file:
// --environment brings it.
#include "scenes/all_scenes.h"
#include "scenes/shapes.h"
#include "scenes/statue.h"

namespace sheen::scenes {
namespace {

constexpr double kHalfWidth = 2.5, kHeight = 3.8;
constexpr double kNear = 2.5, kFar = -13.5;  // along z
constexpr double kFloorRoughness = 0.35;
constexpr double kPlinth = 0.5;

// The windows of the left wall: sill and head, half their width, how deep the wall is.
constexpr double kSill = 0.9, kHead = 3.1, kHalfWindow = 0.9, kDepth = 0.35;
constexpr double kWindows[] = {-3.0, -8.5};

// A rectangle of the left wall, between two places along z.
void addLeft(Mesh& mesh, double z_near, double z_far, double low, double high) {
    addQuad(mesh, {dvec3(-kHalfWidth, low, z_near), dvec3(-kHalfWidth, low, z_far),
                   dvec3(-kHalfWidth, high, z_far), dvec3(-kHalfWidth, high, z_near)});
}

// What lies between the wall and the open air: sill, head and both jambs.
void addReveal(Mesh& mesh, double z_near, double z_far) {
    const double in = -kHalfWidth, out = -kHalfWidth - kDepth;
    addQuad(mesh, {dvec3(out, kSill, z_near), dvec3(in, kSill, z_near), dvec3(in, kSill, z_far),
                   dvec3(out, kSill, z_far)});
    addQuad(mesh, {dvec3(out, kHead, z_far), dvec3(in, kHead, z_far), dvec3(in, kHead, z_near),
                   dvec3(out, kHead, z_near)});
    addQuad(mesh, {dvec3(out, kSill, z_far), dvec3(in, kSill, z_far), dvec3(in, kHead, z_far),
                   dvec3(out, kHead, z_far)});
    addQuad(mesh, {dvec3(in, kSill, z_near), dvec3(out, kSill, z_near), dvec3(out, kHead, z_near),
                   dvec3(in, kHead, z_near)});
}

Mesh leftWall() {
    Mesh mesh;
    double from = kNear;
    for (const double window : kWindows) {
        const double near = window + kHalfWindow, far = window - kHalfWindow;
        addLeft(mesh, from, near, 0.0, kHeight);
        addLeft(mesh, near, far, 0.0, kSill);
        addLeft(mesh, near, far, kHead, kHeight);
        addReveal(mesh, near, far);
        from = far;
    }
    addLeft(mesh, from, kFar, 0.0, kHeight);
    return mesh;
}

// A luminous panel, facing down, and the frame that hangs it from the ceiling.
constexpr double kHalfPanel = 0.6, kHang = 0.08, kFrame = 0.04;

Mesh panel() {
    Mesh mesh;
    const double y = kHeight - kHang;
    addQuad(mesh, {dvec3(-kHalfPanel, y, -kHalfPanel), dvec3(kHalfPanel, y, -kHalfPanel),
                   dvec3(kHalfPanel, y, kHalfPanel), dvec3(-kHalfPanel, y, kHalfPanel)});
    return mesh;
}

Mesh panelFrame() {
    constexpr double kLap = 0.01;  // reaches a little into the ceiling and below the panel
    Mesh mesh;
    const double low = kHeight - kHang - kLap, high = kHeight + kLap;
    const double in = kHalfPanel, out = kHalfPanel + kFrame;
    addBox(mesh, dvec3(-out, low, -out), dvec3(out, high, -in));
    addBox(mesh, dvec3(-out, low, in), dvec3(out, high, out));
    addBox(mesh, dvec3(-out, low, -in), dvec3(-in, high, in));
    addBox(mesh, dvec3(in, low, -in), dvec3(out, high, in));
    return mesh;
}

Mesh plinth() {
    Mesh mesh;
    addBox(mesh, dvec3(-0.42, -0.01, -0.42), dvec3(0.42, kPlinth, 0.42));
    return mesh;
}

void addRoom(Model& model) {
    const auto paint = [&](const char* name, const dvec3& color) {
        return model.add({.name = name, .base_color = color, .specular = 0.0});
    };
    const int plaster = paint("plaster", {0.74, 0.73, 0.70});
    const int end = paint("end wall", {0.50, 0.16, 0.12});
    const std::array<Mesh, 6> walls =
        roomWalls(dvec3(-kHalfWidth, 0.0, kFar), dvec3(kHalfWidth, kHeight, kNear));
    model.add("left wall", leftWall(), plaster);
    model.add("right wall", walls[1], plaster);
    model.add("floor", walls[2],
              model.add({.name = "polished floor",
                         .base_color = dvec3(0.34, 0.27, 0.20),
                         .roughness = kFloorRoughness}));
    model.add("ceiling", walls[3], plaster);
    model.add("end wall", walls[4], end);
    model.add("near wall", walls[5], plaster);
}

}  // namespace

Model gallery() {
    Model model;
    addRoom(model);
    std::vector<dmat4> panels;
    for (const double z : {0.0, -4.0, -8.0, -12.0}) {
        panels.push_back(placement(dvec3(0.0, 0.0, z)));
    }
    model.add("panel", panel(),
              model.add({.name = "luminous panel",
                         .base_color = dvec3(0.6),
                         .specular = 0.0,
                         .emission = dvec3(12.0, 11.4, 10.4)}),
              panels);
    model.add("panel frame", panelFrame(),
              model.add({.name = "frame", .base_color = dvec3(0.2), .specular = 0.0}), panels);

    const dvec3 near(1.35, 0.0, -3.2), far(-1.2, 0.0, -7.2);
    model.add("plinth", plinth(),
              model.add({.name = "plinth", .base_color = dvec3(0.25, 0.26, 0.28), .specular = 0.0}),
              {placement(near), placement(far)});
    const dvec3 up(0.0, kPlinth, 0.0);
    model.add(
        "statue", statue(),
        model.add({.name = "marble", .base_color = dvec3(0.72, 0.69, 0.63), .roughness = 0.5}),
        {placement(near + up, -60.0 * kDegree), placement(far + up, 50.0 * kDegree)});
    model.cameras.push_back({.name = "entrance",
                             .position = dvec3(-0.4, 1.6, 2.1),
                             .target = dvec3(0.1, 1.25, -6.0),
                             .y_fov = 50.0 * kDegree});
    model.cameras.push_back({.name = "window",
                             .position = dvec3(1.6, 1.5, 0.4),
                             .target = dvec3(-1.6, 1.4, -5.0),
                             .y_fov = 50.0 * kDegree});
    return model;
}

}  // namespace sheen::scenes
