#include "light/light_cells.h"

#include <algorithm>
#include <cmath>

#include "core/parallel.h"
#include "light/punctual.h"
#include "rays/surface_point.h"

namespace sheen {
namespace {

// How long a cell may be: this share of the size of the scene, or of the least box around what is
// near that the triangle reaches into; more where all cells together would exceed their budget. An
// edge is divided no more often than one as long as the box is.
constexpr float kLengthOfSize = 1.0f / 256.0f;
constexpr float kMostOfEdge = 256.0f;
constexpr size_t kBudget = 1 << 22;

// A cell may be larger than what a ray stands for by this factor: neighbouring rays then see one
// cell, or its neighbours, and together as much light.
constexpr float kLargestOfRay = 4.0f;

// Nearer to a light than this many times its longest edge, a cell's middle does not stand for all
// of it: its light varies by more than a quarter.
constexpr float kNearEdges = 8.0f;

struct Triangle {
    vec3 p0, e1, e2;

    Triangle(const Scene& scene, uint32_t index) {
        const uvec3& t = scene.triangles[index];
        p0 = scene.positions[t.x];
        e1 = scene.positions[t.y] - p0;
        e2 = scene.positions[t.z] - p0;
    }
    vec3 at(const vec2& uv) const { return p0 + uv.x * e1 + uv.y * e2; }
    float longestEdge() const {
        return std::max({glm::length(e1), glm::length(e2), glm::length(e2 - e1)});
    }
    float area() const { return 0.5f * glm::length(glm::cross(e1, e2)); }
};

// A triangle whose edges are divided n times: n^2 cells, in rows of constant v. A row alternates
// between cells that point as the triangle does and cells between two of those.
struct Grid {
    uint32_t n;

    size_t cellCount() const { return size_t{n} * n; }
    size_t cornerCount() const { return size_t{n + 1} * (n + 2) / 2; }
    uint32_t firstOfRow(uint32_t j) const { return j * (2 * n - j); }
    uint32_t corner(uint32_t i, uint32_t j) const { return j * (2 * n + 3 - j) / 2 + i; }

    // body(cell, its three corners, (u, v) of its middle)
    template <class F>
    void forEachCell(const F& body) const {
        const float step = 1.0f / static_cast<float>(n);
        for (uint32_t j = 0; j < n; ++j) {
            for (uint32_t i = 0; i + j < n; ++i) {
                const uint32_t cell = firstOfRow(j) + 2 * i;
                const uint32_t right = corner(i + 1, j);
                const uint32_t above = corner(i, j + 1);
                body(cell, uvec3(corner(i, j), right, above), step * (vec2(i, j) + 1.0f / 3.0f));
                if (i + j + 1 < n) {
                    body(cell + 1, uvec3(corner(i + 1, j + 1), right, above),
                         step * (vec2(i, j) + 2.0f / 3.0f));
                }
            }
        }
    }
    std::vector<vec2> corners() const {
        std::vector<vec2> uvs;
        uvs.reserve(cornerCount());
        for (uint32_t j = 0; j <= n; ++j) {
            for (uint32_t i = 0; i + j <= n; ++i) {
                uvs.push_back(vec2(i, j) / static_cast<float>(n));
            }
        }
        return uvs;
    }
    std::vector<vec2> middles() const {
        std::vector<vec2> uvs(cellCount());
        forEachCell([&](uint32_t cell, const uvec3&, const vec2& middle) { uvs[cell] = middle; });
        return uvs;
    }
    uint32_t cellAt(float u, float v) const {
        const float x = std::max(u * static_cast<float>(n), 0.0f);
        const float y = std::max(v * static_cast<float>(n), 0.0f);
        const uint32_t j = std::min(static_cast<uint32_t>(y), n - 1);
        const uint32_t i = std::min(static_cast<uint32_t>(x), n - 1 - j);
        const bool between =
            i + j + 1 < n && x - static_cast<float>(i) + y - static_cast<float>(j) > 1.0f;
        return firstOfRow(j) + 2 * i + (between ? 1 : 0);
    }
};

// How often a triangle's edges are divided, of each triangle: at most into kMostOfEdge, and where
// the budget does not allow that, all less often by one factor.
std::vector<uint32_t> divisions(const Scene& scene, const std::vector<Bounds>& near) {
    const auto count = static_cast<size_t>(scene.triangleCount());
    std::vector<float> wanted(count);
    for (size_t i = 0; i < count; ++i) {
        Bounds reach;
        for (int corner = 0; corner < 3; ++corner) {
            reach.add(scene.positions[scene.triangles[i][corner]]);
        }
        float size = scene.bounds.size();
        for (const Bounds& box : near) {
            const bool apart = glm::any(glm::greaterThan(reach.lower, box.upper)) ||
                               glm::any(glm::greaterThan(box.lower, reach.upper));
            size = apart ? size : std::min(size, box.size());
        }
        const float edge = Triangle(scene, static_cast<uint32_t>(i)).longestEdge();
        wanted[i] = std::min(edge / (kLengthOfSize * size), kMostOfEdge);
    }
    std::vector<uint32_t> result(count);
    for (float factor = 1.0f;; factor *= 1.1f) {
        size_t cells = 0;
        for (size_t i = 0; i < count; ++i) {
            result[i] = static_cast<uint32_t>(std::max(std::ceil(wanted[i] / factor), 1.0f));
            cells += Grid{result[i]}.cellCount();
        }
        if (cells <= std::max(kBudget, count)) {
            return result;
        }
    }
}

}  // namespace

struct LightCells::LitTriangle {
    Side sides[2];
    std::vector<Cell> cells[2];
};

LightCells::LightCells(const Tracer& tracer, const std::vector<Bounds>& near) {
    const std::vector<uint32_t> n = divisions(tracer.scene(), near);
    const size_t count = n.size();
    std::vector<LitTriangle> lit(count);
    parallelFor(
        static_cast<int>(count),
        [&](int i) {
            const auto t = static_cast<size_t>(i);
            lit[t] = light(tracer, static_cast<uint32_t>(i), n[t]);
        },
        16);
    sides_.reserve(2 * count);
    for (LitTriangle& triangle : lit) {
        for (int i = 0; i < 2; ++i) {
            std::vector<Cell>& cells = triangle.cells[i];
            triangle.sides[i].first = static_cast<uint32_t>(cells_.size());
            sides_.push_back(triangle.sides[i]);
            cells_.insert(cells_.end(), cells.begin(), cells.end());
            cells = {};
        }
    }
}

LightCells::LitTriangle LightCells::light(const Tracer& tracer, uint32_t index, uint32_t n) {
    const Scene& scene = tracer.scene();
    const Triangle triangle(scene, index);
    const Grid grid{n};
    const float edge = triangle.longestEdge() / static_cast<float>(n);
    const vec3 front = geometricNormal(scene, static_cast<int>(index));
    const Material& material = scene.materials[scene.materials_of[index]];
    const bool lambertian = isLambertian(material.params);
    const size_t light_count = std::min(scene.lights.size(), kOtherLights);
    const auto others =
        static_cast<uint16_t>(scene.lights.size() > kOtherLights ? bit(kOtherLights) : 0u);

    // A plane has a light on one side.
    uint32_t facing[2] = {0, 0};
    for (size_t l = 0; l < light_count; ++l) {
        const vec3 wi = shared::sampleLight(scene.lights[l], triangle.p0).wi;
        facing[glm::dot(front, wi) > 0.0f ? 0 : 1] |= bit(l);
    }

    // Which lights reach the cells' corners and middles, and which of them with all their light.
    struct Reached {
        std::vector<uint32_t> some, whole;
    };
    const auto reachedAt = [&](const std::vector<vec2>& uvs) {
        Reached result{std::vector<uint32_t>(uvs.size()), std::vector<uint32_t>(uvs.size())};
        for (size_t first = 0; first < uvs.size(); first += Tracer::kPacket) {
            const size_t count = std::min<size_t>(Tracer::kPacket, uvs.size() - first);
            SurfaceSide points[Tracer::kPacket];
            for (size_t l = 0; l < light_count; ++l) {
                for (size_t k = 0; k < count; ++k) {
                    const vec3 position = triangle.at(uvs[first + k]);
                    points[k] = {.position = position,
                                 .n_g = (facing[0] & bit(l)) != 0 ? front : -front,
                                 .toward_viewer = vec3(0.0f),
                                 .offset = surfaceOffset(scene, index, position, front, edge)};
                }
                const Tracer::Shares shares = reaching(tracer, scene.lights[l], {points, count});
                for (size_t k = 0; k < count; ++k) {
                    result.some[first + k] |= shares[k] > 0.0f ? bit(l) : 0u;
                    result.whole[first + k] |= shares[k] == 1.0f ? bit(l) : 0u;
                }
            }
        }
        return result;
    };
    const Reached corners = reachedAt(grid.corners());
    const Reached middles = reachedAt(grid.middles());

    // A light reaches all of a cell, or none of it, where its corners and its middle agree. So that
    // no shadow slips between them unseen, cells that touch one where they do not stay open too.
    std::vector<uint32_t> open(corners.some.size());
    grid.forEachCell([&](uint32_t cell, const uvec3& c, const vec2&) {
        const uint32_t any =
            corners.some[c.x] | corners.some[c.y] | corners.some[c.z] | middles.some[cell];
        const uint32_t all =
            corners.whole[c.x] & corners.whole[c.y] & corners.whole[c.z] & middles.whole[cell];
        for (int k = 0; k < 3; ++k) {
            open[c[k]] |= any & ~all;
        }
    });

    LitTriangle result;
    for (int side = 0; side < 2; ++side) {
        std::vector<Cell>& cells = result.cells[side];
        const Cell unlit{.shade = others, .trace = others};
        if (facing[side] == 0) {
            cells.assign(1, unlit);
            continue;
        }
        cells.assign(grid.cellCount(), unlit);
        result.sides[side].n = n;
        result.sides[side].area = triangle.area() / static_cast<float>(grid.cellCount());
        const vec3 n_g = side == 0 ? front : -front;
        grid.forEachCell([&](uint32_t i, const uvec3& c, const vec2& uv) {
            const uint32_t trace = (open[c.x] | open[c.y] | open[c.z]) & facing[side];
            const uint32_t lit = middles.whole[i] & ~trace & facing[side];
            Cell& cell = cells[i];
            cell.trace |= static_cast<uint16_t>(trace);
            cell.shade |= static_cast<uint16_t>(lambertian ? trace : trace | lit);
            if (!lambertian || lit == 0) {
                return;
            }
            const SurfacePoint p = surfacePoint(scene, index, uv.x, uv.y, n_g, edge);
            const Scatterer surface = scattererAt(scene, p);
            for (size_t l = 0; l < light_count; ++l) {
                if ((lit & bit(l)) == 0) {
                    continue;
                }
                const LightSample sample = shared::sampleLight(scene.lights[l], p.position);
                if (sample.distance >= 0.0f && sample.distance < kNearEdges * edge) {
                    cell.shade |= static_cast<uint16_t>(bit(l));
                } else {
                    cell.radiance += scattered(surface, p.wo, sample);
                }
            }
        });
    }
    return result;
}

const LightCells::Cell* LightCells::find(uint32_t triangle, float u, float v, bool back,
                                         float area) const {
    const Side& side = sides_[2 * triangle + (back ? 1 : 0)];
    if (side.area > kLargestOfRay * area) {
        return nullptr;
    }
    return &cells_[side.first + (side.n > 1 ? Grid{side.n}.cellAt(u, v) : 0u)];
}

}  // namespace sheen
