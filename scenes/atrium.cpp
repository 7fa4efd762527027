// A two-storey colonnade around a court, with vaulted galleries below and beamed ones above: a
// building of many small parts, sun in the court, and galleries that live by reflected light.
#include <cmath>

#include "scenes/all_scenes.h"
#include "scenes/atrium_parts.h"
#include "scenes/shapes.h"

namespace sheen::scenes {
namespace {

constexpr double kBay = 2.0;
constexpr int kBaysX = 4;  // of the court
constexpr int kBaysZ = 7;
constexpr double kArcade = 0.19;                     // half the thickness of the arcade's wall
constexpr double kVault = 1.0;                       // half the width of a vault
constexpr double kGallery = kArcade + 2.0 * kVault;  // from the columns' axis to the outer wall
constexpr double kColumn = 2.5;                      // heights of the ground floor
constexpr double kArch = 1.5;
constexpr double kFloor = kColumn + kArch + 0.35;  // of the upper gallery
constexpr double kUpperColumn = 1.75;
constexpr double kUpperArch = 1.35;
constexpr double kRoof = kFloor + 0.30 + kUpperColumn + kUpperArch;
constexpr double kTop = kRoof + 0.75;

constexpr double kHalfX = 0.5 * kBay * kBaysX;  // columns' axis
constexpr double kHalfZ = 0.5 * kBay * kBaysZ;
constexpr double kOuterX = kHalfX + kGallery;
constexpr double kOuterZ = kHalfZ + kGallery;

struct Side {
    double turn;   // about y: the court lies toward +z of the side's own frame
    double half;   // half its length along the columns' axis
    double depth;  // of the columns' axis from the centre
    int bays;
};
const std::array<Side, 4> kSides = {{{0.0, kHalfX, kHalfZ, kBaysX},
                                     {0.5 * kPi, kHalfZ, kHalfX, kBaysZ},
                                     {kPi, kHalfX, kHalfZ, kBaysX},
                                     {1.5 * kPi, kHalfZ, kHalfX, kBaysZ}}};

// A point given along a side (x), up, and toward the court from the columns' axis (z).
dmat4 onSide(const Side& side, double x, double y, double z) {
    return placement(dvec3(0.0), side.turn) * placement(dvec3(x, y, z - side.depth));
}

// Places one element in every bay, or at every column between bays.
std::vector<dmat4> atBays(double y) {
    std::vector<dmat4> places;
    for (const Side& side : kSides) {
        for (int i = 0; i < side.bays; ++i) {
            places.push_back(onSide(side, (i + 0.5) * kBay - side.half, y, 0.0));
        }
    }
    return places;
}

std::vector<dmat4> atColumns(double y) {
    std::vector<dmat4> places;
    for (const Side& side : kSides) {
        for (int i = 1; i < side.bays; ++i) {
            places.push_back(onSide(side, i * kBay - side.half, y, 0.0));
        }
    }
    return places;
}

std::vector<dmat4> atCorners(double y) {
    std::vector<dmat4> places;
    for (const double x : {-kHalfX, kHalfX}) {
        for (const double z : {-kHalfZ, kHalfZ}) {
            places.push_back(placement(dvec3(x, y, z)));
        }
    }
    return places;
}

// A moulding all around the court, on the face of the wall; profile in (toward the court, up).
Mesh aroundCourt(const std::vector<dvec2>& profile, double y, double face) {
    Mesh mesh;
    const double x = kHalfX - face;
    const double z = kHalfZ - face;
    // Seen from above the court lies to the right of this way round. The ends are mitred.
    const std::array<dvec3, 4> corner = {dvec3(-x, y, -z), dvec3(x, y, -z), dvec3(x, y, z),
                                         dvec3(-x, y, z)};
    for (size_t k = 0; k < 4; ++k) {
        const dvec3& from = corner[k];
        const dvec3& to = corner[(k + 1) % 4];
        const dvec3 along = glm::normalize(to - from);
        const dvec3 out = glm::cross(along, dvec3(0, 1, 0));
        for (size_t i = 0; i + 1 < profile.size(); ++i) {
            const auto at = [&](const dvec3& end, const dvec2& p, double mitre) {
                return end + p.x * (out + mitre * along) + dvec3(0, p.y, 0);
            };
            addQuad(mesh, {at(from, profile[i], 1.0), at(to, profile[i], -1.0),
                           at(to, profile[i + 1], -1.0), at(from, profile[i + 1], 1.0)});
        }
    }
    return mesh;
}

// A horizontal ring around the court from the columns' axis shifted by `inner` to the outer wall;
// up or down.
Mesh ring(double y, double inner, bool up) {
    Mesh mesh;
    const double x = kHalfX - inner;
    const double z = kHalfZ - inner;
    const std::array<std::array<double, 4>, 4> parts = {{{-kOuterX, -x, -kOuterZ, kOuterZ},
                                                         {x, kOuterX, -kOuterZ, kOuterZ},
                                                         {-x, x, -kOuterZ, -z},
                                                         {-x, x, z, kOuterZ}}};
    for (const auto& [x0, x1, z0, z1] : parts) {
        if (up) {
            addQuad(mesh, {dvec3(x0, y, z1), dvec3(x1, y, z1), dvec3(x1, y, z0), dvec3(x0, y, z0)},
                    1, 1);
        } else {
            addQuad(mesh, {dvec3(x0, y, z0), dvec3(x1, y, z0), dvec3(x1, y, z1), dvec3(x0, y, z1)},
                    1, 1);
        }
    }
    return mesh;
}

Mesh scaledUvs(Mesh mesh, double repeat_in_metres) {
    for (dvec2& uv : mesh.uvs) {
        uv /= repeat_in_metres;
    }
    return mesh;
}

// The outer walls, facing the court, with a door in every second bay of each floor.
struct Walls {
    Mesh stone;
    std::vector<dmat4> doors;
};
Walls outerWalls(double y, double height) {
    Walls walls;
    for (const Side& side : kSides) {
        const double length = 2.0 * (side.half + kGallery);
        const int panels = side.bays / 2 + 1;
        const double panel = length / panels;
        for (int i = 0; i < panels; ++i) {
            const dmat4 place = onSide(side, (i + 0.5) * panel - 0.5 * length, y, -kGallery);
            if (panels < 4 || i % 2 == 1) {
                walls.stone.append(wallWithDoor(0.5 * panel, height, 0.55, 2.2), place);
                walls.doors.push_back(place);
            } else {
                const double half = 0.5 * panel;
                Mesh blank;
                addQuad(blank, {dvec3(-half, 0, 0), dvec3(half, 0, 0), dvec3(half, height, 0),
                                dvec3(-half, height, 0)});
                walls.stone.append(blank, place);
            }
        }
    }
    return walls;
}

// Beams under the upper gallery's roof, from the outer wall to the court's wall.
std::vector<dmat4> beamPlaces() {
    std::vector<dmat4> places;
    for (const Side& side : kSides) {
        for (int i = 0; i <= 2 * side.bays; ++i) {
            places.push_back(onSide(side, 0.5 * i * kBay - side.half, kRoof - 0.22, 0.0));
        }
    }
    return places;
}

// Vaults over the ground-floor gallery, one a bay and one a corner.
std::vector<dmat4> vaultPlaces() {
    std::vector<dmat4> places;
    const double y = kFloor - 0.30 - kVault;
    for (const Side& side : kSides) {
        for (int i = 0; i < side.bays; ++i) {
            places.push_back(onSide(side, (i + 0.5) * kBay - side.half, y, -kArcade - kVault));
        }
        places.push_back(onSide(side, side.half + kArcade + kVault, y, -kArcade - kVault));
    }
    return places;
}

// The ribs that close the gap between a corner's vault and its neighbours.
std::vector<dmat4> ribPlaces() {
    std::vector<dmat4> places;
    const double y = kFloor - 0.30 - kVault;
    for (const Side& side : kSides) {
        for (const double end : {-1.0, 1.0}) {
            places.push_back(onSide(side, end * (side.half + 0.5 * kArcade), y, -kArcade - kVault) *
                             placement(dvec3(0.0), 0.5 * kPi));
        }
    }
    return places;
}

void addStructure(Model& model, int stone, int plaster, int marble) {
    model.add("column", column(kColumn, 0.19, 22), marble, atColumns(0.0));
    model.add("upper column", column(kUpperColumn, 0.125, 20), marble, atColumns(kFloor + 0.30));
    model.add("pier", pier(kColumn, 0.24), stone, atCorners(0.0));
    model.add("upper pier", pier(kUpperColumn + 0.30, 0.22), stone, atCorners(kFloor));
    Mesh arch = archedWall({.bay = kBay, .height = kArch + 0.35});
    Mesh upper_arch = archedWall(
        {.bay = kBay, .height = kUpperArch, .radius = 0.84, .half_depth = 0.15, .segments = 14});
    model.add("arch", scaledUvs(arch, 2.0), stone, atBays(kColumn));
    model.add("upper arch", scaledUvs(upper_arch, 2.0), stone,
              atBays(kFloor + 0.30 + kUpperColumn));
    // Pedestals of the upper columns, with balustrades between them.
    Mesh pedestal;
    addBox(pedestal, dvec3(-0.20, 0.0, -0.20), dvec3(0.20, 0.30, 0.20));
    model.add("pedestal", pedestal, marble, atColumns(kFloor));
    model.add("balustrade", balustrade(kBay - 0.40, 5), marble, atBays(kFloor));
    model.add("vault", groinVault(kVault, 8), plaster, vaultPlaces());
    Mesh rib = archedWall({.bay = 2.0 * kVault,
                           .height = kVault + 0.02,
                           .radius = 0.96 * kVault,
                           .half_depth = 0.5 * kArcade,
                           .segments = 12});
    model.add("rib", scaledUvs(rib, 2.0), stone, ribPlaces());
    Mesh beam;
    addBox(beam, dvec3(-0.09, 0.0, -kGallery), dvec3(0.09, 0.22, -0.15));
    model.add("beam", beam,
              model.add({.name = "oak", .base_color = dvec3(0.28, 0.17, 0.09), .specular = 0.0}),
              beamPlaces());
}

void addSurfaces(Model& model, int stone, int plaster, int floor) {
    const Walls ground = outerWalls(0.0, kFloor);
    const Walls upper = outerWalls(kFloor, kTop - kFloor);
    Mesh walls = ground.stone;
    walls.append(upper.stone);
    model.add("outer walls", scaledUvs(walls, 2.0), stone);
    std::vector<dmat4> doors = ground.doors;
    doors.insert(doors.end(), upper.doors.begin(), upper.doors.end());
    model.add("door", doorway(0.55, 2.2, 0.25),
              model.add({.name = "green door",
                         .base_color = dvec3(0.09, 0.22, 0.16),
                         .roughness = roughnessFromAlpha(0.35)}),
              doors);

    Mesh paving;
    addQuad(paving, {dvec3(-kOuterX, 0, kOuterZ), dvec3(kOuterX, 0, kOuterZ),
                     dvec3(kOuterX, 0, -kOuterZ), dvec3(-kOuterX, 0, -kOuterZ)});
    model.add("paving", scaledUvs(paving, 2.0), floor);

    Mesh slabs = ring(kFloor, -0.02, true);
    slabs.append(ring(kFloor - 0.30, -0.19, false));
    slabs.append(ring(kRoof, -0.10, false));
    slabs.append(ring(kTop, 0.15, true));
    model.add("slabs", slabs, plaster);
    Mesh parapet = aroundCourt({{0.0, 0.0}, {0.0, kTop - kRoof}}, kRoof, 0.15);
    model.add("parapet", scaledUvs(parapet, 2.0), stone);
}

void addMouldings(Model& model, int marble) {
    // A string course at the upper floor, a cornice under the roof's edge.
    Mesh mouldings = aroundCourt(
        {{0.0, -0.22}, {0.05, -0.20}, {0.05, -0.15}, {0.11, -0.09}, {0.11, -0.03}, {0.0, 0.0}},
        kFloor, 0.19);
    mouldings.append(aroundCourt({{0.0, -0.05},
                                  {0.05, 0.0},
                                  {0.05, 0.06},
                                  {0.10, 0.10},
                                  {0.20, 0.20},
                                  {0.20, 0.28},
                                  {0.0, 0.33}},
                                 kRoof, 0.15));
    model.add("mouldings", mouldings, marble);
}

}  // namespace

Model atrium() {
    Model model;
    model.textures = {encodePng(stoneCourses()), encodePng(paving())};
    const int stone =
        model.add({.name = "cut stone", .base_color = dvec3(0.95), .specular = 0.0, .texture = 0});
    const int plaster =
        model.add({.name = "plaster", .base_color = dvec3(0.72, 0.66, 0.56), .specular = 0.0});
    const int marble =
        model.add({.name = "pale marble", .base_color = dvec3(0.70, 0.67, 0.62), .specular = 0.0});
    const int floor =
        model.add({.name = "paving", .base_color = dvec3(0.95), .specular = 0.0, .texture = 1});
    addStructure(model, stone, plaster, marble);
    addSurfaces(model, stone, plaster, floor);
    addMouldings(model, marble);

    const int bronze = model.add({.name = "bronze",
                                  .base_color = dvec3(0.72, 0.45, 0.22),
                                  .metallic = 1.0,
                                  .roughness = roughnessFromAlpha(0.3)});
    model.add("vase", vase(), bronze,
              {placement(dvec3(-1.9, 0.0, 2.2)), placement(dvec3(1.9, 0.0, 2.2)),
               placement(dvec3(-1.9, 0.0, -2.2)), placement(dvec3(1.9, 0.0, -2.2))});
    Mesh ball;
    addSphere(ball, dvec3(0.0, 0.55, 0.0), 0.55, 3);
    model.add("sphere", ball,
              model.add({.name = "glazed sphere",
                         .base_color = dvec3(0.12, 0.20, 0.42),
                         .roughness = roughnessFromAlpha(0.25),
                         .specular_color = 3.0}),
              {placement(dvec3(0.0, 0.0, -1.0))});

    model.lights.push_back({.name = "sun",
                            .type = "directional",
                            .position = dvec3(-2.2, 5.4, -6.7),
                            .target = dvec3(0.0),
                            .color = dvec3(1.0, 0.93, 0.82),
                            .intensity = 100.0});
    model.lights.push_back({.name = "gallery lamp",
                            .type = "point",
                            .position = dvec3(-kHalfX - 1.2, 2.9, 1.0),
                            .color = dvec3(1.0, 0.80, 0.55),
                            .intensity = 18.0});
    model.cameras.push_back({.name = "court",
                             .position = dvec3(1.1, 1.7, kHalfZ + 0.9),
                             .target = dvec3(-0.5, 1.45, -kHalfZ),
                             .y_fov = 48.0 * kDegree});
    model.cameras.push_back({.name = "gallery",
                             .position = dvec3(-kHalfX - 1.2, 1.65, kHalfZ - 0.5),
                             .target = dvec3(-kHalfX - 0.8, 1.75, -kHalfZ),
                             .y_fov = 58.0 * kDegree});
    model.cameras.push_back({.name = "upper",
                             .position = dvec3(kHalfX + 0.9, kFloor + 1.6, kHalfZ + 0.6),
                             .target = dvec3(-1.0, kFloor - 0.2, -kHalfZ),
                             .y_fov = 55.0 * kDegree});
    return model;
}

}  // namespace sheen::scenes
