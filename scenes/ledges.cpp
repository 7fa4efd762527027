// Contacts and thin ledges: cornices, louvres, stacked thin slabs and a chair on a floor, most of
// whose parts are one to three pixels thick in a small image.
#include "scenes/all_scenes.h"
#include "scenes/shapes.h"

namespace sheen::scenes {
namespace {

constexpr double kHalfWidth = 2.0, kHeight = 2.8, kHalfDepth = 2.0;

// A box that stands on the point `at`, tilted about its longest horizontal axis x by `tilt` and
// then turned about y.
Mesh plank(const dvec3& size, const dvec3& at, double turn = 0.0, double tilt = 0.0) {
    Mesh box;
    addBox(box, {-0.5 * size.x, 0.0, -0.5 * size.z}, {0.5 * size.x, size.y, 0.5 * size.z});
    const dquat about_x = glm::angleAxis(tilt, dvec3(1, 0, 0));
    Mesh mesh;
    mesh.append(box, placement(at, turn) * glm::mat4_cast(about_x));
    return mesh;
}

// String courses on the back wall: a shelf's edge, a cornice of three steps, a drip mould.
Mesh cornices() {
    const dvec3 from(-kHalfWidth, 0, -kHalfDepth);
    const dvec3 to(kHalfWidth, 0, -kHalfDepth);
    Mesh mesh;
    addMoulding(mesh, {{0, 0.85}, {0.08, 0.85}, {0.08, 0.868}, {0, 0.868}}, from, to);
    addMoulding(mesh,
                {{0, 1.55},
                 {0.03, 1.55},
                 {0.03, 1.58},
                 {0.07, 1.58},
                 {0.07, 1.60},
                 {0.12, 1.60},
                 {0.12, 1.625},
                 {0, 1.625}},
                from, to);
    addMoulding(mesh,
                {{0, 2.25}, {0.05, 2.27}, {0.05, 2.255}, {0.065, 2.255}, {0.065, 2.30}, {0, 2.31}},
                from, to);
    return mesh;
}

// Slats before the left wall, which light passes between.
Mesh louvres() {
    Mesh mesh;
    for (int i = 0; i < 16; ++i) {
        mesh.append(plank({1.3, 0.008, 0.075}, {-kHalfWidth + 0.09, 1.0 + 0.065 * i, -0.9},
                          90.0 * kDegree, -38.0 * kDegree));
    }
    for (double z : {-1.57, -0.23}) {
        mesh.append(plank({0.03, 1.12, 0.09}, {-kHalfWidth + 0.09, 0.96, z}, 90.0 * kDegree));
    }
    return mesh;
}

// Slabs that lie on each other, each a little turned, and slabs on spacers with gaps as thin as
// they.
Mesh slabs() {
    Mesh mesh;
    for (int i = 0; i < 8; ++i) {
        mesh.append(plank({0.52 - 0.03 * i, 0.014, 0.36 - 0.02 * i}, {1.25, 0.014 * i, -0.55},
                          (4.0 + 5.0 * i) * kDegree));
    }
    for (int i = 0; i < 7; ++i) {
        const double y = 0.034 * i;
        mesh.append(plank({0.46, 0.012, 0.32}, {0.45, y + 0.022, -1.35}, -9.0 * kDegree));
        for (double x : {-0.2, 0.2}) {
            mesh.append(plank({0.02, 0.022, 0.30}, {0.45 + x, y, -1.35}, -9.0 * kDegree));
        }
    }
    return mesh;
}

Mesh chair() {
    Mesh mesh;
    for (double x : {-0.19, 0.19}) {
        mesh.append(plank({0.034, 0.43, 0.034}, {x, 0.0, 0.18}));
        mesh.append(plank({0.034, 0.92, 0.030}, {x, 0.0, -0.19}));
        mesh.append(plank({0.018, 0.022, 0.34}, {x, 0.20, 0.0}));
    }
    mesh.append(plank({0.42, 0.022, 0.41}, {0.0, 0.43, 0.0}));
    for (int i = 0; i < 4; ++i) {
        mesh.append(plank({0.35, 0.045, 0.012}, {0.0, 0.60 + 0.085 * i, -0.19}));
    }
    return mesh;
}

}  // namespace

Model ledges() {
    Model model;
    const auto paint = [&](const char* name, const dvec3& color) {
        return model.add({.name = name, .base_color = color, .specular = 0.0});
    };
    const int plaster = paint("plaster", {0.75, 0.73, 0.69});
    const int boards = paint("boards", {0.42, 0.31, 0.22});
    const int slate = paint("slate", {0.55, 0.58, 0.6});
    const int varnish =
        model.add({.name = "varnish", .base_color = dvec3(0.5, 0.24, 0.11), .roughness = 0.6});

    const std::array<Mesh, 6> walls =
        roomWalls({-kHalfWidth, 0, -kHalfDepth}, {kHalfWidth, kHeight, kHalfDepth});
    const char* names[] = {"left wall", "right wall", "floor",
                           "ceiling",   "back wall",  "front wall"};
    for (size_t i = 0; i < walls.size(); ++i) {
        model.add(names[i], walls[i], i == 2 ? boards : plaster);
    }
    model.add("cornices", cornices(), plaster);
    model.add("louvres", louvres(), plaster);
    model.add("slabs", slabs(), slate);
    model.add("chair", chair(), varnish,
              {placement({-0.45, 0.0, -0.35}, 25.0 * kDegree),
               placement({-1.2, 0.0, 0.35}, -70.0 * kDegree)});
    // Grazing the back wall, so that ledges are lit and what lies below them is not.
    model.lights.push_back({.name = "washer",
                            .type = "spot",
                            .position = dvec3(0.3, 2.7, -1.55),
                            .target = dvec3(0.2, 0.9, -1.9),
                            .intensity = 3.0,
                            .inner_cone = 30.0 * kDegree,
                            .outer_cone = 75.0 * kDegree});
    model.lights.push_back({.name = "window",
                            .type = "spot",
                            .position = dvec3(-1.95, 2.5, -0.9),
                            .target = dvec3(0.2, 0.0, -0.6),
                            .intensity = 6.0,
                            .inner_cone = 15.0 * kDegree,
                            .outer_cone = 40.0 * kDegree});
    model.cameras.push_back({.name = "room",
                             .position = dvec3(1.35, 1.45, 1.9),
                             .target = dvec3(-0.25, 0.95, -1.4),
                             .y_fov = 58.0 * kDegree});
    model.cameras.push_back({.name = "slabs",
                             .position = dvec3(1.0, 0.65, 0.6),
                             .target = dvec3(0.6, 0.12, -1.0),
                             .y_fov = 50.0 * kDegree});
    return model;
}

}  // namespace sheen::scenes
