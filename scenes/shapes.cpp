#include "scenes/shapes.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace sheen::scenes {
namespace {

uint32_t addVertex(Mesh& mesh, const dvec3& p, const dvec3& n, const dvec2& uv) {
    mesh.positions.push_back(p);
    mesh.normals.push_back(n);
    mesh.uvs.push_back(uv);
    return static_cast<uint32_t>(mesh.positions.size()) - 1;
}

void addTriangle(Mesh& mesh, uint32_t a, uint32_t b, uint32_t c) {
    mesh.indices.insert(mesh.indices.end(), {a, b, c});
}

// Texture coordinates in metres, on the axis plane the normal faces most.
dvec2 planarUv(const dvec3& p, const dvec3& n) {
    const dvec3 a = glm::abs(n);
    if (a.y >= a.x && a.y >= a.z) {
        return {p.x, p.z};
    }
    return a.x >= a.z ? dvec2(p.z, -p.y) : dvec2(p.x, -p.y);
}

// One band of a lathe between two profile points with the normals given in (outward, up).
void addLatheBand(Mesh& mesh, const ProfilePoint& low, const ProfilePoint& high, const dvec2& n_low,
                  const dvec2& n_high, int segments) {
    std::vector<uint32_t> lower;
    std::vector<uint32_t> upper;
    for (int i = 0; i <= segments; ++i) {
        const double phi = 2.0 * kPi * (i % segments) / segments;
        const dvec3 out(std::sin(phi), 0.0, std::cos(phi));
        const double u = static_cast<double>(i) / segments;
        const auto vertex = [&](const ProfilePoint& point, const dvec2& n) {
            return addVertex(mesh, point.radius * out + dvec3(0, point.height, 0),
                             n.x * out + dvec3(0, n.y, 0), {u, -point.height});
        };
        lower.push_back(vertex(low, n_low));
        upper.push_back(vertex(high, n_high));
    }
    for (size_t i = 0; i < static_cast<size_t>(segments); ++i) {
        if (low.radius > 0.0) {
            addTriangle(mesh, lower[i], lower[i + 1], upper[i + 1]);
        }
        if (high.radius > 0.0) {
            addTriangle(mesh, lower[i], upper[i + 1], upper[i]);
        }
    }
}

}  // namespace

void addQuad(Mesh& mesh, const std::array<dvec3, 4>& corners, int cells_u, int cells_v) {
    const dvec3 n = glm::normalize(glm::cross(corners[1] - corners[0], corners[3] - corners[0]));
    const auto first = static_cast<uint32_t>(mesh.positions.size());
    for (int v = 0; v <= cells_v; ++v) {
        for (int u = 0; u <= cells_u; ++u) {
            const double s = static_cast<double>(u) / cells_u;
            const dvec3 p =
                glm::mix(glm::mix(corners[0], corners[1], s), glm::mix(corners[3], corners[2], s),
                         static_cast<double>(v) / cells_v);
            addVertex(mesh, p, n, planarUv(p, n));
        }
    }
    const auto row = static_cast<uint32_t>(cells_u) + 1;
    for (uint32_t v = 0; v < static_cast<uint32_t>(cells_v); ++v) {
        for (uint32_t u = 0; u < static_cast<uint32_t>(cells_u); ++u) {
            const uint32_t i = first + v * row + u;
            addTriangle(mesh, i, i + 1, i + row + 1);
            addTriangle(mesh, i, i + row + 1, i + row);
        }
    }
}

void addBox(Mesh& mesh, const dvec3& l, const dvec3& u) {
    const auto at = [&](int x, int y, int z) {
        return dvec3(x != 0 ? u.x : l.x, y != 0 ? u.y : l.y, z != 0 ? u.z : l.z);
    };
    addQuad(mesh, {at(0, 0, 0), at(0, 0, 1), at(0, 1, 1), at(0, 1, 0)});
    addQuad(mesh, {at(1, 0, 1), at(1, 0, 0), at(1, 1, 0), at(1, 1, 1)});
    addQuad(mesh, {at(0, 0, 0), at(1, 0, 0), at(1, 0, 1), at(0, 0, 1)});
    addQuad(mesh, {at(0, 1, 1), at(1, 1, 1), at(1, 1, 0), at(0, 1, 0)});
    addQuad(mesh, {at(1, 0, 0), at(0, 0, 0), at(0, 1, 0), at(1, 1, 0)});
    addQuad(mesh, {at(0, 0, 1), at(1, 0, 1), at(1, 1, 1), at(0, 1, 1)});
}

std::array<Mesh, 6> roomWalls(const dvec3& l, const dvec3& u) {
    const auto at = [&](int x, int y, int z) {
        return dvec3(x != 0 ? u.x : l.x, y != 0 ? u.y : l.y, z != 0 ? u.z : l.z);
    };
    std::array<Mesh, 6> walls;
    addQuad(walls[0], {at(0, 0, 1), at(0, 0, 0), at(0, 1, 0), at(0, 1, 1)});
    addQuad(walls[1], {at(1, 0, 0), at(1, 0, 1), at(1, 1, 1), at(1, 1, 0)});
    addQuad(walls[2], {at(0, 0, 1), at(1, 0, 1), at(1, 0, 0), at(0, 0, 0)});
    addQuad(walls[3], {at(0, 1, 0), at(1, 1, 0), at(1, 1, 1), at(0, 1, 1)});
    addQuad(walls[4], {at(0, 0, 0), at(1, 0, 0), at(1, 1, 0), at(0, 1, 0)});
    addQuad(walls[5], {at(1, 0, 1), at(0, 0, 1), at(0, 1, 1), at(1, 1, 1)});
    return walls;
}

void addLathe(Mesh& mesh, const std::vector<ProfilePoint>& profile, int segments, bool square) {
    std::vector<dvec2> band_normals;
    for (size_t i = 0; i + 1 < profile.size(); ++i) {
        const dvec2 along(profile[i + 1].radius - profile[i].radius,
                          profile[i + 1].height - profile[i].height);
        band_normals.push_back(glm::normalize(dvec2(along.y, -along.x)));
    }
    for (size_t i = 0; i + 1 < profile.size(); ++i) {
        if (square) {
            const auto corner = [](const ProfilePoint& p, int k) {
                const double sx = k == 0 || k == 3 ? -1.0 : 1.0;
                const double sz = k < 2 ? 1.0 : -1.0;
                return dvec3(sx * p.radius, p.height, sz * p.radius);
            };
            for (int k = 0; k < 4; ++k) {
                const int next = (k + 1) % 4;
                addQuad(mesh, {corner(profile[i], k), corner(profile[i], next),
                               corner(profile[i + 1], next), corner(profile[i + 1], k)});
            }
            continue;
        }
        const auto normal_at = [&](size_t point, const dvec2& own) {
            const bool smooth = !profile[point].sharp && point > 0 && point + 1 < profile.size();
            return smooth ? glm::normalize(band_normals[point - 1] + band_normals[point]) : own;
        };
        addLatheBand(mesh, profile[i], profile[i + 1], normal_at(i, band_normals[i]),
                     normal_at(i + 1, band_normals[i]), segments);
    }
}

void addSphere(Mesh& mesh, const dvec3& center, double radius, int levels, bool inward) {
    const double g = 0.5 * (1.0 + std::sqrt(5.0));
    std::vector<dvec3> points = {{-1, g, 0}, {1, g, 0}, {-1, -g, 0}, {1, -g, 0},
                                 {0, -1, g}, {0, 1, g}, {0, -1, -g}, {0, 1, -g},
                                 {g, 0, -1}, {g, 0, 1}, {-g, 0, -1}, {-g, 0, 1}};
    for (dvec3& p : points) {
        p = glm::normalize(p);
    }
    std::vector<glm::uvec3> faces = {{0, 11, 5}, {0, 5, 1},  {0, 1, 7},   {0, 7, 10}, {0, 10, 11},
                                     {1, 5, 9},  {5, 11, 4}, {11, 10, 2}, {10, 7, 6}, {7, 1, 8},
                                     {3, 9, 4},  {3, 4, 2},  {3, 2, 6},   {3, 6, 8},  {3, 8, 9},
                                     {4, 9, 5},  {2, 4, 11}, {6, 2, 10},  {8, 6, 7},  {9, 8, 1}};
    for (int level = 0; level < levels; ++level) {
        std::map<std::pair<uint32_t, uint32_t>, uint32_t> middles;
        const auto middle = [&](uint32_t a, uint32_t b) {
            const auto [found, is_new] =
                middles.try_emplace(std::minmax(a, b), static_cast<uint32_t>(points.size()));
            if (is_new) {
                points.push_back(glm::normalize(points[a] + points[b]));
            }
            return found->second;
        };
        std::vector<glm::uvec3> finer;
        for (const glm::uvec3& f : faces) {
            const uint32_t ab = middle(f.x, f.y);
            const uint32_t bc = middle(f.y, f.z);
            const uint32_t ca = middle(f.z, f.x);
            finer.insert(finer.end(), {{f.x, ab, ca}, {f.y, bc, ab}, {f.z, ca, bc}, {ab, bc, ca}});
        }
        faces = std::move(finer);
    }
    const auto first = static_cast<uint32_t>(mesh.positions.size());
    for (const dvec3& p : points) {
        addVertex(mesh, center + radius * p, inward ? -p : p, {0.0, 0.0});
    }
    for (const glm::uvec3& f : faces) {
        addTriangle(mesh, first + f.x, first + (inward ? f.z : f.y), first + (inward ? f.y : f.z));
    }
}

void addMoulding(Mesh& mesh, const std::vector<dvec2>& profile, const dvec3& from,
                 const dvec3& to) {
    const dvec3 along = glm::normalize(to - from);
    const dvec3 out = glm::cross(along, dvec3(0, 1, 0));
    for (size_t i = 0; i + 1 < profile.size(); ++i) {
        const dvec3 low = profile[i].x * out + dvec3(0, profile[i].y, 0);
        const dvec3 high = profile[i + 1].x * out + dvec3(0, profile[i + 1].y, 0);
        addQuad(mesh, {from + low, to + low, to + high, from + high});
    }
}

dmat4 placement(const dvec3& position, double turn_about_y) {
    const double c = std::cos(turn_about_y);
    const double s = std::sin(turn_about_y);
    return {{c, 0, -s, 0}, {0, 1, 0, 0}, {s, 0, c, 0}, glm::dvec4(position, 1.0)};
}

}  // namespace sheen::scenes
