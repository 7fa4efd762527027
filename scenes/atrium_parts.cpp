#include "scenes/atrium_parts.h"

#include <algorithm>
#include <cmath>

#include "scenes/shapes.h"

namespace sheen::scenes {
namespace {

// A half-round moulding between two heights: `bulge` beyond `radius`.
void addTorus(std::vector<ProfilePoint>& profile, double radius, double bulge, double low,
              double high, int steps) {
    for (int i = 0; i <= steps; ++i) {
        const double t = kPi * i / steps;
        if (i == 0 && !profile.empty() && profile.back().height == low &&
            profile.back().radius == radius) {
            continue;  // it starts where the profile has ended
        }
        profile.push_back({radius + bulge * std::sin(t),
                           low + (high - low) * 0.5 * (1 - std::cos(t)), i == 0 || i == steps});
    }
}

// A ring of quads between two arcs of the upper half circle: in the wall's plane (front), or across
// it (from z to z2 at one radius, facing the centre).
void addArcBand(Mesh& mesh, double inner, double outer, double z, int segments, bool front) {
    for (int i = 0; i < segments; ++i) {
        const auto at = [&](int k, double r) {
            const double phi = kPi * k / segments;
            return dvec3(r * std::cos(phi), r * std::sin(phi), z);
        };
        if (front) {
            addQuad(mesh, {at(i, inner), at(i, outer), at(i + 1, outer), at(i + 1, inner)});
        } else {
            addQuad(mesh, {at(i + 1, inner), at(i + 1, outer), at(i, outer), at(i, inner)});
        }
    }
}

// The cylinder of the upper half circle between two depths, facing the centre or away from it.
void addArcSoffit(Mesh& mesh, double radius, double z0, double z1, int segments, bool inward) {
    const auto first = static_cast<uint32_t>(mesh.positions.size());
    for (int i = 0; i <= segments; ++i) {
        const double phi = kPi * i / segments;
        const dvec3 out(std::cos(phi), std::sin(phi), 0.0);
        for (const double z : {z0, z1}) {
            mesh.positions.push_back(radius * out + dvec3(0, 0, z));
            mesh.normals.push_back(inward ? -out : out);
            mesh.uvs.push_back({z, radius * phi});
        }
    }
    for (uint32_t i = 0; i < static_cast<uint32_t>(segments); ++i) {
        const uint32_t a = first + 2 * i;
        if (inward) {
            mesh.indices.insert(mesh.indices.end(), {a, a + 3, a + 2, a, a + 1, a + 3});
        } else {
            mesh.indices.insert(mesh.indices.end(), {a, a + 2, a + 3, a, a + 3, a + 1});
        }
    }
}

// One face of a wall with an arched opening: strips from the arc to the rectangle's border.
void addSpandrels(Mesh& mesh, const ArchSpec& s, double z, bool front) {
    for (int i = 0; i < s.segments; ++i) {
        const auto arc = [&](int k) {
            const double phi = kPi * k / s.segments;
            return dvec3(s.radius * std::cos(phi), s.radius * std::sin(phi), z);
        };
        const dvec3 a = arc(i);
        const dvec3 b = arc(i + 1);
        const dvec3 top_a(a.x, s.height, z);
        const dvec3 top_b(b.x, s.height, z);
        if (front) {
            addQuad(mesh, {b, a, top_a, top_b});
        } else {
            addQuad(mesh, {a, b, top_b, top_a});
        }
    }
    for (const double side : {-1.0, 1.0}) {
        const double x0 = std::min(side * s.radius, side * 0.5 * s.bay);
        const double x1 = std::max(side * s.radius, side * 0.5 * s.bay);
        if (front) {
            addQuad(mesh, {dvec3(x0, 0, z), dvec3(x1, 0, z), dvec3(x1, s.height, z),
                           dvec3(x0, s.height, z)});
        } else {
            addQuad(mesh, {dvec3(x1, 0, z), dvec3(x0, 0, z), dvec3(x0, s.height, z),
                           dvec3(x1, s.height, z)});
        }
    }
}

uint32_t hashed(uint32_t x) {
    x ^= x >> 16;
    x *= 0x7feb352du;
    x ^= x >> 15;
    x *= 0x846ca68bu;
    return x ^ (x >> 16);
}

// In [0, 1), from integers only.
double noise(int x, int y, uint32_t seed) {
    const uint32_t h = hashed(static_cast<uint32_t>(x) * 7919u +
                              static_cast<uint32_t>(y) * 104729u + seed * 2654435761u);
    return (h >> 8) / 16777216.0;
}

// Value noise on a lattice of `cell` pixels that repeats every `period` pixels.
double smoothNoise(int x, int y, int cell, int period, uint32_t seed) {
    const int count = period / cell;
    const double fx = static_cast<double>(x % cell) / cell;
    const double fy = static_cast<double>(y % cell) / cell;
    const auto at = [&](int i, int j) {
        return noise((x / cell + i) % count, (y / cell + j) % count, seed);
    };
    return glm::mix(glm::mix(at(0, 0), at(1, 0), fx), glm::mix(at(0, 1), at(1, 1), fx), fy);
}

constexpr int kPictureSize = 256;

Picture picture(const dvec3& stone, const dvec3& joint, int rows, int columns, bool staggered) {
    Picture result{kPictureSize, kPictureSize, {}};
    for (int y = 0; y < kPictureSize; ++y) {
        for (int x = 0; x < kPictureSize; ++x) {
            const int row_height = kPictureSize / rows;
            const int width = kPictureSize / columns;
            const int row = y / row_height;
            const int shifted = (x + (staggered && row % 2 == 1 ? width / 2 : 0)) % kPictureSize;
            const int column = shifted / width;
            const int to_joint = std::min({y % row_height, row_height - 1 - y % row_height,
                                           shifted % width, width - 1 - shifted % width});
            const double grain = 0.5 * smoothNoise(x, y, 16, kPictureSize, 1) +
                                 0.3 * smoothNoise(x, y, 4, kPictureSize, 2) + 0.2 * noise(x, y, 3);
            const double block = noise(column, row, 4);
            const double warm = noise(column, row, 5) - 0.5;
            dvec3 color = stone * (0.82 + 0.16 * block + 0.16 * (grain - 0.5));
            color *= dvec3(1.0 + 0.06 * warm, 1.0, 1.0 - 0.08 * warm);
            if (to_joint < 2) {
                color = glm::mix(joint, color, to_joint == 0 ? 0.0 : 0.55);
            }
            const auto byte = [](double v) {
                return static_cast<uint8_t>(std::lround(std::clamp(v, 0.0, 1.0) * 255.0));
            };
            result.pixels.push_back({byte(color.x), byte(color.y), byte(color.z)});
        }
    }
    return result;
}

}  // namespace

Mesh column(double height, double radius, int segments) {
    const double r = radius;
    Mesh mesh;
    // Plinth and abacus are square.
    addBox(mesh, dvec3(-1.42 * r, 0.0, -1.42 * r), dvec3(1.42 * r, 0.42 * r, 1.42 * r));
    addBox(mesh, dvec3(-1.45 * r, height - 0.38 * r, -1.45 * r), dvec3(1.45 * r, height, 1.45 * r));
    std::vector<ProfilePoint> profile;
    addTorus(profile, 1.18 * r, 0.20 * r, 0.42 * r, 0.74 * r, 4);
    profile.push_back({1.10 * r, 0.80 * r, false});
    addTorus(profile, 1.05 * r, 0.12 * r, 0.88 * r, 1.08 * r, 4);
    profile.push_back({r, 1.16 * r, true});
    // The shaft tapers in a slight curve.
    const double shaft_top = height - 1.75 * r;
    for (int i = 1; i <= 4; ++i) {
        const double t = i / 4.0;
        profile.push_back({r * (1.0 - 0.16 * t * t),
                           i == 4 ? shaft_top : glm::mix(1.16 * r, shaft_top, t), i == 4});
    }
    addTorus(profile, profile.back().radius, 0.10 * r, shaft_top, shaft_top + 0.16 * r, 4);
    profile.push_back({0.84 * r, shaft_top + 0.40 * r, false});
    // The capital widens to the abacus.
    profile.push_back({0.90 * r, shaft_top + 0.70 * r, false});
    profile.push_back({1.08 * r, shaft_top + 1.05 * r, false});
    profile.push_back({1.36 * r, shaft_top + 1.30 * r, true});
    profile.push_back({1.36 * r, height - 0.38 * r, true});
    addLathe(mesh, profile, segments);
    return mesh;
}

Mesh pier(double height, double w) {
    Mesh mesh;
    addLathe(mesh,
             {{1.18 * w, 0.0},
              {1.18 * w, 0.30},
              {1.08 * w, 0.36},
              {w, 0.40},
              {w, height - 0.30},
              {1.08 * w, height - 0.26},
              {1.08 * w, height - 0.20},
              {1.2 * w, height - 0.12},
              {1.2 * w, height}},
             4, true);
    return mesh;
}

Mesh archedWall(const ArchSpec& s) {
    constexpr double kBand = 0.13;
    constexpr double kRelief = 0.035;
    Mesh mesh;
    for (const double side : {-1.0, 1.0}) {
        const bool front = side > 0.0;
        addSpandrels(mesh, s, side * s.half_depth, front);
        // The moulding around the arch: its face and its outer edge.
        const double relief = side * (s.half_depth + kRelief);
        addArcBand(mesh, s.radius, s.radius + kBand, relief, s.segments, front);
        addArcSoffit(mesh, s.radius + kBand, std::min(relief, side * s.half_depth),
                     std::max(relief, side * s.half_depth), s.segments, false);
        addBox(mesh, dvec3(-0.08, s.radius - 0.03, front ? s.half_depth : -s.half_depth - 0.07),
               dvec3(0.08, s.radius + 0.26, front ? s.half_depth + 0.07 : -s.half_depth));
    }
    addArcSoffit(mesh, s.radius, -s.half_depth - kRelief, s.half_depth + kRelief, s.segments, true);
    return mesh;
}

Mesh balustrade(double length, int count) {
    Mesh mesh;
    addBox(mesh, dvec3(-0.5 * length, 0.0, -0.11), dvec3(0.5 * length, 0.10, 0.11));
    addBox(mesh, dvec3(-0.5 * length, 0.80, -0.12), dvec3(0.5 * length, 0.92, 0.12));
    Mesh baluster;
    addLathe(baluster,
             {{0.060, 0.10, true},
              {0.060, 0.15, true},
              {0.035, 0.18},
              {0.066, 0.32},
              {0.058, 0.42},
              {0.030, 0.60},
              {0.034, 0.70},
              {0.058, 0.75, true},
              {0.058, 0.80, true}},
             8);
    for (int i = 0; i < count; ++i) {
        const double x = length * ((i + 0.5) / count - 0.5);
        mesh.append(baluster, placement(dvec3(x, 0.0, 0.0)));
    }
    return mesh;
}

Mesh groinVault(double half, int cells) {
    Mesh mesh;
    // Of two crossing half cylinders, what lies inside either is open.
    const auto height = [&](double x, double z) {
        const double across_x = std::sqrt(std::max(0.0, half * half - x * x));
        const double across_z = std::sqrt(std::max(0.0, half * half - z * z));
        return std::max(across_x, across_z);
    };
    // Cells are finer toward the walls, where the vault is steep, and meet along the groins.
    const auto coordinate = [&](int i) { return -half * std::cos(kPi * i / cells); };
    for (int j = 0; j < cells; ++j) {
        for (int i = 0; i < cells; ++i) {
            const auto at = [&](int u, int v) {
                const double x = coordinate(u);
                const double z = coordinate(v);
                return dvec3(x, height(x, z), z);
            };
            const std::array<dvec3, 4> c = {at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)};
            // Split along the groins, so that each half lies on one cylinder.
            const bool rising = (i < cells / 2) == (j < cells / 2);
            const std::array<std::array<size_t, 3>, 2> split =
                rising ? std::array<std::array<size_t, 3>, 2>{{{0, 1, 2}, {0, 2, 3}}}
                       : std::array<std::array<size_t, 3>, 2>{{{0, 1, 3}, {1, 2, 3}}};
            for (const auto& t : split) {
                const dvec3 middle = (c[t[0]] + c[t[1]] + c[t[2]]) / 3.0;
                for (const size_t k : t) {
                    // The normal of the cylinder this triangle lies on, toward its axis.
                    const bool along_z = std::abs(middle.x) < std::abs(middle.z);
                    const double s = along_z ? c[k].x : c[k].z;
                    const double down = -std::sqrt(std::max(0.0, half * half - s * s));
                    const dvec3 n = along_z ? dvec3(-s, down, 0) : dvec3(0, down, -s);
                    mesh.positions.push_back(c[k]);
                    mesh.normals.push_back(n / half);
                    mesh.uvs.push_back({c[k].x, c[k].z});
                    mesh.indices.push_back(static_cast<uint32_t>(mesh.indices.size()));
                }
            }
        }
    }
    return mesh;
}

Mesh doorway(double half_width, double height, double recess) {
    Mesh mesh;
    const double w = half_width;
    // Threshold, jambs and lintel of the recess, and the door itself.
    addQuad(mesh, {dvec3(-w, 0, 0), dvec3(w, 0, 0), dvec3(w, 0, -recess), dvec3(-w, 0, -recess)});
    addQuad(mesh, {dvec3(-w, 0, 0), dvec3(-w, 0, -recess), dvec3(-w, height, -recess),
                   dvec3(-w, height, 0)});
    addQuad(mesh,
            {dvec3(w, 0, -recess), dvec3(w, 0, 0), dvec3(w, height, 0), dvec3(w, height, -recess)});
    addQuad(mesh, {dvec3(-w, height, -recess), dvec3(w, height, -recess), dvec3(w, height, 0),
                   dvec3(-w, height, 0)});
    addQuad(mesh, {dvec3(-w, 0, -recess), dvec3(w, 0, -recess), dvec3(w, height, -recess),
                   dvec3(-w, height, -recess)});
    for (const double x : {-0.5 * w, 0.5 * w}) {
        for (int panel = 0; panel < 3; ++panel) {
            const double y0 = height * (0.06 + 0.31 * panel);
            addBox(mesh, dvec3(x - 0.36 * w, y0, -recess),
                   dvec3(x + 0.36 * w, y0 + 0.25 * height, -recess + 0.04));
        }
    }
    // The frame around the opening.
    addBox(mesh, dvec3(-w - 0.16, 0.0, 0.0), dvec3(-w, height, 0.06));
    addBox(mesh, dvec3(w, 0.0, 0.0), dvec3(w + 0.16, height, 0.06));
    addBox(mesh, dvec3(-w - 0.22, height, 0.0), dvec3(w + 0.22, height + 0.18, 0.09));
    return mesh;
}

Mesh vase() {
    Mesh mesh;
    addLathe(mesh,
             {{0.00, 0.00, true},
              {0.20, 0.00, true},
              {0.20, 0.05, true},
              {0.12, 0.09},
              {0.10, 0.14},
              {0.18, 0.24},
              {0.27, 0.38},
              {0.31, 0.52},
              {0.29, 0.64},
              {0.21, 0.73},
              {0.18, 0.78},
              {0.21, 0.84},
              {0.25, 0.87, true},
              {0.22, 0.88, true},
              {0.16, 0.80},
              {0.00, 0.74, true}},
             28);
    return mesh;
}

Mesh wallWithDoor(double half, double height, double w, double door_height) {
    Mesh mesh;
    const auto add = [&](double x0, double x1, double y0, double y1) {
        addQuad(mesh, {dvec3(x0, y0, 0), dvec3(x1, y0, 0), dvec3(x1, y1, 0), dvec3(x0, y1, 0)});
    };
    add(-half, -w, 0.0, height);
    add(w, half, 0.0, height);
    add(-w, w, door_height, height);
    return mesh;
}

Picture stoneCourses() { return picture({0.80, 0.72, 0.60}, {0.52, 0.47, 0.40}, 6, 3, true); }

Picture paving() { return picture({0.70, 0.66, 0.61}, {0.36, 0.34, 0.31}, 4, 4, false); }

}  // namespace sheen::scenes
