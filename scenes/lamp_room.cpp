// A corner of a living room with lamps that have an extent: a sphere in a shade open above and
// below, and a small bulb that hangs from a cord; a mirror and a metal ring show them again.
#include <cmath>

#include "scenes/all_scenes.h"
#include "scenes/shapes.h"

namespace sheen::scenes {
namespace {

constexpr double kTable = 0.72;  // height of its top
constexpr dvec3 kLamp(0.75, kTable, -0.95);
constexpr dvec3 kBulb(-0.55, 1.75, -0.5);
constexpr double kCeiling = 2.5;

Mesh table() {
    constexpr double kThick = 0.04, kLeg = 0.05, kLap = 0.01;
    constexpr double kHalfLength = 0.75, kHalfDepth = 0.4;
    Mesh mesh;
    addBox(mesh, dvec3(-kHalfLength, kTable - kThick, -kHalfDepth),
           dvec3(kHalfLength, kTable, kHalfDepth));
    for (const double x : {-1.0, 1.0}) {
        for (const double z : {-1.0, 1.0}) {
            const dvec3 at(x * (kHalfLength - 0.06), 0.0, z * (kHalfDepth - 0.06));
            addBox(mesh, at + dvec3(-0.5 * kLeg, -kLap, -0.5 * kLeg),
                   at + dvec3(0.5 * kLeg, kTable - kThick + kLap, 0.5 * kLeg));
        }
    }
    return mesh;
}

// Foot and stem of the table lamp; its sphere rests on the stem.
constexpr double kSphere = 0.07, kSphereHeight = 0.38;

Mesh lampFoot() {
    Mesh mesh;
    addLathe(mesh,
             {{0.0, -0.005},
              {0.11, -0.005, true},
              {0.11, 0.012, true},
              {0.03, 0.03},
              {0.012, 0.06},
              {0.012, kSphereHeight - kSphere + 0.01, true},
              {0.0, kSphereHeight - kSphere + 0.01}},
             32);
    return mesh;
}

Mesh shade() {
    Mesh mesh;
    addLathe(mesh, {{0.19, 0.26}, {0.12, 0.52}}, 48);
    return mesh;
}

Mesh cord() {
    Mesh mesh;
    addLathe(mesh, {{0.006, 0.045}, {0.006, kCeiling - kBulb.y + 0.01}}, 12);
    addLathe(mesh, {{0.016, 0.03}, {0.018, 0.08, true}, {0.0, 0.08}}, 16);
    return mesh;
}

// A ring that lies around y, of that radius; `thick` is its wire's.
Mesh ring(double radius, double thick) {
    constexpr int kAround = 64, kWire = 20;
    Mesh mesh;
    for (int i = 0; i <= kAround; ++i) {
        const double u = 2.0 * kPi * i / kAround;
        for (int j = 0; j <= kWire; ++j) {
            const double v = 2.0 * kPi * j / kWire;
            const dvec3 out(std::cos(u), 0.0, std::sin(u));
            const dvec3 normal = std::cos(v) * out + dvec3(0.0, std::sin(v), 0.0);
            mesh.positions.push_back(radius * out + thick * normal);
            mesh.normals.push_back(normal);
            mesh.uvs.emplace_back(u * radius, v * thick);
        }
    }
    for (uint32_t i = 0; i < kAround; ++i) {
        for (uint32_t j = 0; j < kWire; ++j) {
            const uint32_t a = i * (kWire + 1) + j, b = a + kWire + 1;
            mesh.indices.insert(mesh.indices.end(), {a, a + 1, b + 1, a, b + 1, b});
        }
    }
    return mesh;
}

// The mirror hangs before the right wall, its frame's back in it.
constexpr double kRight = 1.6;
constexpr double kMirrorLow = 1.0, kMirrorHigh = 2.0, kMirrorNear = -0.1, kMirrorFar = -1.2;

Mesh mirror() {
    constexpr double kAhead = 0.02;
    const double x = kRight - kAhead;
    Mesh mesh;
    addQuad(mesh, {dvec3(x, kMirrorLow, kMirrorFar), dvec3(x, kMirrorLow, kMirrorNear),
                   dvec3(x, kMirrorHigh, kMirrorNear), dvec3(x, kMirrorHigh, kMirrorFar)});
    return mesh;
}

Mesh mirrorFrame() {
    constexpr double kWide = 0.05, kDeep = 0.035, kLap = 0.01;
    const double front = kRight - kDeep, back = kRight + kLap;
    const double low = kMirrorLow - kWide, high = kMirrorHigh + kWide;
    Mesh mesh;
    addBox(mesh, dvec3(front, low, kMirrorFar - kWide), dvec3(back, high, kMirrorFar));
    addBox(mesh, dvec3(front, low, kMirrorNear), dvec3(back, high, kMirrorNear + kWide));
    addBox(mesh, dvec3(front, low, kMirrorFar), dvec3(back, kMirrorLow, kMirrorNear));
    addBox(mesh, dvec3(front, kMirrorHigh, kMirrorFar), dvec3(back, high, kMirrorNear));
    return mesh;
}

Mesh sphere(double radius) {
    constexpr int kLevels = 3;
    Mesh mesh;
    addSphere(mesh, dvec3(0.0), radius, kLevels);
    return mesh;
}

void addRoom(Model& model) {
    const auto paint = [&](const char* name, const dvec3& color) {
        return model.add({.name = name, .base_color = color, .specular = 0.0});
    };
    const std::array<int, 6> materials = {
        paint("green wall", {0.22, 0.36, 0.24}),
        paint("right wall", {0.72, 0.68, 0.60}),
        model.add({.name = "floor", .base_color = dvec3(0.38, 0.24, 0.13), .roughness = 0.45}),
        paint("ceiling", {0.78, 0.77, 0.75}),
        paint("back wall", {0.70, 0.62, 0.50}),
        paint("front wall", {0.65, 0.65, 0.65})};
    const std::array<const char*, 6> names = {"left wall", "right wall", "floor",
                                              "ceiling",   "back wall",  "front wall"};
    const std::array<Mesh, 6> walls =
        roomWalls(dvec3(-1.7, 0.0, -1.6), dvec3(kRight, kCeiling, 2.4));
    for (size_t i = 0; i < 6; ++i) {
        model.add(names[i], walls[i], materials[i]);
    }
    model.add("table", table(), paint("wood", {0.45, 0.28, 0.15}),
              {placement(dvec3(0.55, 0.0, -1.0))});
}

}  // namespace

Model lampRoom() {
    Model model;
    addRoom(model);
    const int metal = model.add({.name = "brass",
                                 .base_color = dvec3(0.91, 0.78, 0.42),
                                 .metallic = 1.0,
                                 .roughness = 0.3});
    const int dark = model.add({.name = "dark", .base_color = dvec3(0.04), .specular = 0.0});
    model.add("lamp foot", lampFoot(), metal, {placement(kLamp)});
    model.add("shade", shade(),
              model.add({.name = "shade", .base_color = dvec3(0.75, 0.66, 0.5), .specular = 0.0}),
              {placement(kLamp)});
    model.add("lamp", sphere(kSphere),
              model.add({.name = "warm light",
                         .base_color = dvec3(0.5),
                         .specular = 0.0,
                         .emission = dvec3(90.0, 66.0, 40.0)}),
              {placement(kLamp + dvec3(0.0, kSphereHeight, 0.0))});
    model.add("bulb", sphere(0.04),
              model.add({.name = "white light",
                         .base_color = dvec3(0.5),
                         .specular = 0.0,
                         .emission = dvec3(160.0, 150.0, 135.0)}),
              {placement(kBulb)});
    model.add("cord", cord(), dark, {placement(kBulb)});
    model.add("ring", ring(0.13, 0.02), metal, {placement(dvec3(0.25, kTable + 0.018, -0.8))});
    model.add(
        "mirror", mirror(),
        model.add(
            {.name = "mirror", .base_color = dvec3(0.95), .metallic = 1.0, .roughness = 0.0}));
    model.add("mirror frame", mirrorFrame(), dark);
    model.cameras.push_back({.name = "sofa",
                             .position = dvec3(-1.35, 1.45, 1.5),
                             .target = dvec3(0.62, 1.12, -0.9),
                             .y_fov = 48.0 * kDegree});
    model.cameras.push_back({.name = "table",
                             .position = dvec3(-0.15, 1.15, 0.2),
                             .target = dvec3(0.45, 0.8, -0.9),
                             .y_fov = 45.0 * kDegree});
    return model;
}

}  // namespace sheen::scenes
