// Scenes that move, 48 frames at 24 a second each: a kite over a floor, a door that opens into a
// lit room, a camera that circles a statue.
#include <cmath>

#include "scenes/all_scenes.h"
#include "scenes/shapes.h"

namespace sheen::scenes {
namespace {

constexpr int kFrames = 48;
constexpr double kFramesASecond = 24.0;

double secondsOf(int frame) { return frame / kFramesASecond; }

dquat turned(double angle, const dvec3& axis) { return glm::angleAxis(angle, axis); }

int paint(Model& model, const char* name, const dvec3& color) {
    return model.add({.name = name, .base_color = color, .specular = 0.0});
}

// A kite as children draw it, lying in the plane y = 0, its head toward -z: two triangles.
Mesh kiteSail() {
    constexpr double kHead = 0.45, kTail = 0.85, kHalf = 0.5, kSag = 0.12;
    const dvec3 head(0, 0, -kHead), tail(0, 0, kTail), left(-kHalf, kSag, 0), right(kHalf, kSag, 0);
    Mesh mesh;
    // Flat triangles, each with vertices of its own.
    const auto add = [&](const dvec3& a, const dvec3& b, const dvec3& c) {
        const dvec3 normal = glm::normalize(glm::cross(b - a, c - a));
        for (const dvec3& corner : {a, b, c}) {
            mesh.indices.push_back(static_cast<uint32_t>(mesh.positions.size()));
            mesh.positions.push_back(corner);
            mesh.normals.push_back(normal);
            mesh.uvs.emplace_back(corner.x, corner.z);
        }
    };
    add(head, left, tail);
    add(head, tail, right);
    return mesh;
}

// Where it is on its way, 0 to 1: an arc over the floor, low in the middle, leaning into the turn.
Motion::Key kiteAt(int frame) {
    const double way = frame / (kFrames - 1.0);
    const double angle = kPi * (way - 0.5);
    return {
        secondsOf(frame),
        dvec3(1.6 * std::sin(angle), 0.75 - 0.35 * std::cos(angle), -0.5 + 0.5 * std::cos(angle)),
        turned(0.9 * angle, dvec3(0, 1, 0)) * turned(-0.5 * std::sin(angle), dvec3(0, 0, 1)) *
            turned(0.25, dvec3(1, 0, 0))};
}

// The rooms of `doors`: the dark one nearer, the lit one farther than the wall between them.
constexpr double kHalfWidth = 1.8, kHeight = 2.5, kNear = 3.6, kFar = -2.4;
constexpr double kDoorLeft = -0.45, kDoorRight = 0.45, kDoorHead = 2.0, kWallThick = 0.12;

Mesh wallWithDoorway() {
    Mesh mesh;
    addBox(mesh, dvec3(-kHalfWidth - 0.05, -0.05, -kWallThick),
           dvec3(kDoorLeft, kHeight + 0.05, 0));
    addBox(mesh, dvec3(kDoorRight, -0.05, -kWallThick),
           dvec3(kHalfWidth + 0.05, kHeight + 0.05, 0));
    addBox(mesh, dvec3(kDoorLeft, kDoorHead, -kWallThick), dvec3(kDoorRight, kHeight + 0.05, 0));
    return mesh;
}

// The door hangs at its right edge, before the wall, which it overlaps so that no light passes.
constexpr double kLap = 0.04, kDoorThick = 0.04, kInWall = 0.004;

Mesh doorPanel() {
    Mesh mesh;
    addBox(mesh, dvec3(kDoorLeft - kDoorRight - 2 * kLap, -0.01, 0.0),
           dvec3(0.0, kDoorHead + kLap, kDoorThick));
    return mesh;
}

Motion::Key doorAt(int frame) {
    constexpr int kOpens = 12, kOpen = 30;
    constexpr double kWide = 100.0 * kDegree;
    const double way = glm::clamp((frame - kOpens) / double(kOpen - kOpens), 0.0, 1.0);
    return {secondsOf(frame), dvec3(kDoorRight + kLap, 0.0, -kInWall),
            turned(kWide * way * way * (3.0 - 2.0 * way), dvec3(0, 1, 0))};
}

template <class Place>
void move(Model& model, const char* name, const Place& place) {
    Motion motion{.name = name};
    for (int frame = 0; frame < kFrames; ++frame) {
        motion.keys.push_back(place(frame));
    }
    model.motions.push_back(motion);
}

}  // namespace

Model kite() {
    Model model;
    const std::array<int, 6> paints = {paint(model, "left wall", {0.55, 0.60, 0.66}),
                                       paint(model, "right wall", {0.66, 0.60, 0.5}),
                                       paint(model, "floor", {0.72, 0.70, 0.66}),
                                       paint(model, "ceiling", {0.75, 0.75, 0.75}),
                                       paint(model, "back wall", {0.70, 0.70, 0.68}),
                                       paint(model, "front wall", {0.6, 0.6, 0.6})};
    const std::array<const char*, 6> names = {"left wall", "right wall", "floor",
                                              "ceiling",   "back wall",  "front wall"};
    const std::array<Mesh, 6> walls = roomWalls(dvec3(-2.6, 0.0, -2.2), dvec3(2.6, 2.6, 3.2));
    for (size_t i = 0; i < 6; ++i) {
        model.add(names[i], walls[i], paints[i]);
    }
    model.add("kite", kiteSail(), paint(model, "sail", {0.80, 0.12, 0.06}));
    model.lights.push_back({.name = "sun",
                            .type = "spot",
                            .position = dvec3(0.6, 2.5, 1.2),
                            .target = dvec3(0.0, 0.0, -0.4),
                            .color = dvec3(1.0, 0.96, 0.9),
                            .intensity = 24.0,
                            .inner_cone = 25.0 * kDegree,
                            .outer_cone = 62.0 * kDegree});
    model.cameras.push_back({.name = "watcher",
                             .position = dvec3(0.0, 1.35, 3.0),
                             .target = dvec3(0.0, 0.55, -0.6),
                             .y_fov = 52.0 * kDegree});
    move(model, "kite", kiteAt);
    return model;
}

Model doors() {
    Model model;
    const std::array<int, 6> paints = {
        paint(model, "left wall", {0.30, 0.38, 0.50}),
        paint(model, "right wall", {0.55, 0.42, 0.3}),
        model.add({.name = "floor", .base_color = dvec3(0.42, 0.36, 0.30), .roughness = 0.5}),
        paint(model, "ceiling", {0.75, 0.74, 0.72}),
        paint(model, "far wall", {0.8, 0.78, 0.7}),
        paint(model, "front wall", {0.6, 0.6, 0.6})};
    const std::array<const char*, 6> names = {"left wall", "right wall", "floor",
                                              "ceiling",   "far wall",   "front wall"};
    const std::array<Mesh, 6> walls =
        roomWalls(dvec3(-kHalfWidth, 0.0, kFar), dvec3(kHalfWidth, kHeight, kNear));
    for (size_t i = 0; i < 6; ++i) {
        model.add(names[i], walls[i], paints[i]);
    }
    model.add("wall between", wallWithDoorway(), paint(model, "plaster", {0.7, 0.68, 0.64}));
    model.add("door", doorPanel(), paint(model, "door paint", {0.62, 0.64, 0.6}));
    Mesh chest;
    addBox(chest, dvec3(-1.5, -0.01, 0.9), dvec3(-0.9, 0.55, 1.5));
    model.add("chest", chest, paint(model, "wood", {0.5, 0.33, 0.18}));
    model.lights.push_back({.name = "lit room",
                            .type = "point",
                            .position = dvec3(-0.5, 2.0, -1.2),
                            .color = dvec3(1.0, 0.93, 0.82),
                            .intensity = 10.0});
    model.lights.push_back({.name = "night light",
                            .type = "point",
                            .position = dvec3(1.3, 2.2, 2.4),
                            .color = dvec3(0.6, 0.7, 1.0),
                            .intensity = 0.8});
    model.cameras.push_back({.name = "inside",
                             .position = dvec3(-0.7, 1.45, 3.3),
                             .target = dvec3(0.1, 0.95, 0.0),
                             .y_fov = 55.0 * kDegree});
    move(model, "door", doorAt);
    return model;
}

Model orbit() {
    Model model = venusGlossy();
    const dvec3 middle(0.0, 1.2, 0.0);
    const auto place = [&](int frame) {
        constexpr double kRadius = 1.65, kHeightOfEye = 1.35, kFrom = 0.1, kArc = kPi;
        const double angle = kFrom + kArc * frame / (kFrames - 1.0);
        const dvec3 eye(kRadius * std::sin(angle), kHeightOfEye, kRadius * std::cos(angle));
        return Motion::Key{secondsOf(frame), eye, lookRotation(middle - eye)};
    };
    model.cameras.erase(model.cameras.begin() + 1, model.cameras.end());
    model.cameras[0].name = "orbit";
    model.cameras[0].position = place(0).position;
    model.cameras[0].target = middle;
    model.cameras[0].y_fov = 70.0 * kDegree;
    move(model, "orbit", place);
    return model;
}

}  // namespace sheen::scenes
