// A corridor with a polished dielectric floor, which reflects the wall washers' light at grazing
// angles only: of what a low camera sees of the floor most is gloss that is narrow there and faint
// a few metres nearer.
#include "scenes/all_scenes.h"
#include "scenes/shapes.h"

namespace sheen::scenes {
namespace {

constexpr double kHalfWidth = 1.3, kHeight = 2.6;
constexpr double kNear = 2.0, kFar = -18.0;  // along z
constexpr double kFloorRoughness = 0.4;
constexpr double kLamps = 2.5;  // height of the lamps

// The door in the left wall: nearer and farther jamb, head, and how deep it stands in the wall.
constexpr double kDoorNear = -4.6, kDoorFar = -5.6, kDoorHead = 2.1, kDoorDepth = 0.3;

// A rectangle at x that faces the corridor from the left, between two places along z.
void addLeft(Mesh& mesh, double x, double z_near, double z_far, double y_low, double y_high) {
    addQuad(mesh, {dvec3(x, y_low, z_near), dvec3(x, y_low, z_far), dvec3(x, y_high, z_far),
                   dvec3(x, y_high, z_near)});
}

Mesh leftWall() {
    Mesh mesh;
    addLeft(mesh, -kHalfWidth, kNear, kDoorNear, 0.0, kHeight);
    addLeft(mesh, -kHalfWidth, kDoorNear, kDoorFar, kDoorHead, kHeight);
    addLeft(mesh, -kHalfWidth, kDoorFar, kFar, 0.0, kHeight);
    // What lies between the wall and the door: two jambs and the head.
    const double in = -kHalfWidth - kDoorDepth;
    const double out = -kHalfWidth;
    addQuad(mesh, {dvec3(in, 0, kDoorFar), dvec3(out, 0, kDoorFar), dvec3(out, kDoorHead, kDoorFar),
                   dvec3(in, kDoorHead, kDoorFar)});
    addQuad(mesh, {dvec3(out, 0, kDoorNear), dvec3(in, 0, kDoorNear),
                   dvec3(in, kDoorHead, kDoorNear), dvec3(out, kDoorHead, kDoorNear)});
    addQuad(mesh, {dvec3(in, kDoorHead, kDoorFar), dvec3(out, kDoorHead, kDoorFar),
                   dvec3(out, kDoorHead, kDoorNear), dvec3(in, kDoorHead, kDoorNear)});
    return mesh;
}

Mesh door() {
    Mesh mesh;
    addLeft(mesh, -kHalfWidth - kDoorDepth, kDoorNear, kDoorFar, 0.0, kDoorHead);
    return mesh;
}

Mesh floorWithThreshold(const Mesh& floor) {
    Mesh mesh = floor;
    const double in = -kHalfWidth - kDoorDepth;
    addQuad(mesh, {dvec3(in, 0, kDoorNear), dvec3(-kHalfWidth, 0, kDoorNear),
                   dvec3(-kHalfWidth, 0, kDoorFar), dvec3(in, 0, kDoorFar)});
    return mesh;
}

// A pilaster of the right wall; its foot and its back are no surfaces.
Mesh pilaster() {
    constexpr double kHalf = 0.2, kDepth = 0.22;
    Mesh mesh;
    addQuad(mesh, {dvec3(-kDepth, 0, -kHalf), dvec3(-kDepth, 0, kHalf),
                   dvec3(-kDepth, kHeight, kHalf), dvec3(-kDepth, kHeight, -kHalf)});
    addQuad(mesh, {dvec3(-kDepth, 0, kHalf), dvec3(0, 0, kHalf), dvec3(0, kHeight, kHalf),
                   dvec3(-kDepth, kHeight, kHalf)});
    addQuad(mesh, {dvec3(0, 0, -kHalf), dvec3(-kDepth, 0, -kHalf), dvec3(-kDepth, kHeight, -kHalf),
                   dvec3(0, kHeight, -kHalf)});
    return mesh;
}

// A bench 1.6 m long along z; its legs reach a little into floor and seat.
Mesh bench() {
    constexpr double kSeat = 0.42, kLap = 0.01;
    Mesh mesh;
    addBox(mesh, dvec3(-0.2, kSeat, -0.8), dvec3(0.2, kSeat + 0.06, 0.8));
    for (const double z : {-0.6, 0.6}) {
        addBox(mesh, dvec3(-0.17, -kLap, z - 0.04), dvec3(0.17, kSeat + kLap, z + 0.04));
    }
    return mesh;
}

void addSurfaces(Model& model) {
    const auto paint = [&](const char* name, const dvec3& color) {
        return model.add({.name = name, .base_color = color, .specular = 0.0});
    };
    const int plaster = paint("plaster", {0.70, 0.69, 0.66});
    const int ceiling = paint("ceiling", {0.78, 0.78, 0.77});
    const int end = paint("end wall", {0.74, 0.52, 0.26});
    const int leaf = paint("door", {0.20, 0.30, 0.36});
    const int wood = paint("bench", {0.42, 0.27, 0.16});
    const int polished = model.add({.name = "polished floor",
                                    .base_color = dvec3(0.30, 0.29, 0.28),
                                    .roughness = kFloorRoughness});
    const std::array<Mesh, 6> walls =
        roomWalls(dvec3(-kHalfWidth, 0.0, kFar), dvec3(kHalfWidth, kHeight, kNear));
    model.add("left wall", leftWall(), plaster);
    model.add("right wall", walls[1], plaster);
    model.add("floor", floorWithThreshold(walls[2]), polished);
    model.add("ceiling", walls[3], ceiling);
    model.add("end wall", walls[4], end);
    model.add("near wall", walls[5], plaster);
    model.add("door", door(), leaf);
    model.add("pilaster", pilaster(), plaster,
              {placement(dvec3(kHalfWidth, 0, -1.5)), placement(dvec3(kHalfWidth, 0, -6.5)),
               placement(dvec3(kHalfWidth, 0, -11.5))});
    model.add("bench", bench(), wood, {placement(dvec3(-1.05, 0, -10.0))});
}

void addLamps(Model& model) {
    const auto washer = [&](const char* name, double side, double z) {
        model.lights.push_back({.name = name,
                                .type = "spot",
                                .position = dvec3(side * (kHalfWidth - 0.4), kLamps, z),
                                .target = dvec3(side * kHalfWidth, 1.5, z),
                                .color = dvec3(1.0, 0.93, 0.84),
                                .intensity = 30.0,
                                .inner_cone = 12.0 * kDegree,
                                .outer_cone = 36.0 * kDegree});
    };
    washer("right washer 1", 1.0, -4.0);
    washer("left washer 1", -1.0, -7.5);
    washer("right washer 2", 1.0, -9.0);
    washer("left washer 2", -1.0, -13.5);
    model.lights.push_back({.name = "end spot",
                            .type = "spot",
                            .position = dvec3(0.0, kLamps, -15.0),
                            .target = dvec3(0.0, 1.3, kFar),
                            .color = dvec3(1.0, 0.97, 0.92),
                            .intensity = 60.0,
                            .inner_cone = 10.0 * kDegree,
                            .outer_cone = 32.0 * kDegree});
}

}  // namespace

Model corridor() {
    Model model;
    addSurfaces(model);
    addLamps(model);
    model.cameras.push_back({.name = "low",
                             .position = dvec3(0.1, 0.35, 1.4),
                             .target = dvec3(0.0, 0.3, -10.0),
                             .y_fov = 40.0 * kDegree});
    model.cameras.push_back({.name = "eye",
                             .position = dvec3(-0.2, 1.6, 1.4),
                             .target = dvec3(0.0, 0.9, -8.0),
                             .y_fov = 45.0 * kDegree});
    return model;
}

}  // namespace sheen::scenes
