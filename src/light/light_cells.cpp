#include "light/light_cells.h"

#include <algorithm>
#include <array>

#include "core/parallel.h"
#include "light/punctual.h"
#include "light/triangle_grid.h"
#include "rays/surface_point.h"

namespace sheen {
namespace {

// How many there may be (gridDivisions()).
constexpr size_t kMostLightCells = 1 << 22;

// A cell may be larger than what a ray stands for by this factor: neighbouring rays then see one
// cell, or its neighbours, and together as much light.
constexpr float kLargestOfRay = 4.0f;

// Nearer to a light than this many times its longest edge, a cell's middle does not stand for all
// of it: its light varies by more than a quarter.
constexpr float kNearEdges = 8.0f;

// A plane has a light on one side: those on its front, and the others.
std::array<uint32_t, 2> lightsBySide(std::span<const PunctualLight> lights, const vec3& point,
                                     const vec3& front) {
    std::array<uint32_t, 2> facing = {};
    for (size_t l = 0; l < lights.size(); ++l) {
        const vec3 wi = shared::sampleLight(lights[l], point).wi;
        facing[glm::dot(front, wi) > 0.0f ? 0 : 1] |= uint32_t{1} << l;
    }
    return facing;
}

// Of points on a triangle: which lights reach them, and which with all their light. [point]
struct Reached {
    std::vector<uint32_t> some, whole;
};

// `lit_from`: lights that shine on the triangle's front, `edge` the length of a cell's.
Reached reachedAt(const Tracer& tracer, std::span<const PunctualLight> lights, uint32_t index,
                  const std::vector<vec2>& uvs, uint32_t lit_from, float edge) {
    const Scene& scene = tracer.scene();
    const TriangleEdges triangle(scene, index);
    const vec3 front = geometricNormal(scene, static_cast<int>(index));
    Reached result{std::vector<uint32_t>(uvs.size()), std::vector<uint32_t>(uvs.size())};
    for (size_t first = 0; first < uvs.size(); first += Tracer::kPacket) {
        const size_t count = std::min<size_t>(Tracer::kPacket, uvs.size() - first);
        SurfaceSide points[Tracer::kPacket];
        for (size_t l = 0; l < lights.size(); ++l) {
            const uint32_t light = uint32_t{1} << l;
            for (size_t k = 0; k < count; ++k) {
                const vec3 position = triangle.at(uvs[first + k]);
                points[k] = {.position = position,
                             .n_g = (lit_from & light) != 0 ? front : -front,
                             .toward_viewer = vec3(0.0f),
                             .offset = surfaceOffset(scene, index, position, front, edge)};
            }
            const Tracer::Shares shares = reaching(tracer, lights[l], {points, count});
            for (size_t k = 0; k < count; ++k) {
                result.some[first + k] |= shares[k] != vec3(0.0f) ? light : 0u;
                result.whole[first + k] |= shares[k] == vec3(1.0f) ? light : 0u;
            }
        }
    }
    return result;
}

// A light reaches all of a cell, or none of it, where its corners and its middle agree. So that no
// shadow slips between them unseen, cells that touch one where they do not stay open too: by such a
// corner's lights. [corner]
std::vector<uint32_t> openCorners(const TriangleGrid& grid, const Reached& corners,
                                  const Reached& middles) {
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
    return open;
}

}  // namespace

struct LightCells::LitTriangle {
    Side sides[2];
    std::vector<Cell> cells[2];
};

LightCells::LightCells(const Tracer& tracer, std::span<const PunctualLight> lights,
                       const std::vector<Bounds>& near, float length) {
    const std::vector<uint32_t> n = gridDivisions(tracer.scene(), near, length, kMostLightCells);
    const size_t count = n.size();
    std::vector<LitTriangle> lit(count);
    parallelFor(
        static_cast<int>(count),
        [&](int i) {
            const auto t = static_cast<size_t>(i);
            lit[t] = light(tracer, lights, static_cast<uint32_t>(i), n[t]);
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

LightCells::LitTriangle LightCells::light(const Tracer& tracer,
                                          std::span<const PunctualLight> lights, uint32_t index,
                                          uint32_t n) {
    const Scene& scene = tracer.scene();
    const TriangleEdges triangle(scene, index);
    const TriangleGrid grid{n};
    const float edge = triangle.longestEdge() / static_cast<float>(n);
    const vec3 front = geometricNormal(scene, static_cast<int>(index));
    const bool lambertian = isLambertian(scene.materials[scene.materials_of[index]]);
    const size_t light_count = std::min(lights.size(), kOtherLights);
    const auto others =
        static_cast<uint16_t>(lights.size() > kOtherLights ? bit(kOtherLights) : 0u);

    const std::span<const PunctualLight> known = lights.first(light_count);
    const std::array<uint32_t, 2> facing = lightsBySide(known, triangle.p0, front);
    const Reached corners = reachedAt(tracer, known, index, grid.corners(), facing[0], edge);
    const Reached middles = reachedAt(tracer, known, index, grid.middles(), facing[0], edge);
    const std::vector<uint32_t> open = openCorners(grid, corners, middles);

    LitTriangle result;
    for (int side = 0; side < 2; ++side) {
        std::vector<Cell>& cells = result.cells[side];
        const Cell unlit{.shade = others, .trace = others};
        const uint32_t facing_side = facing[static_cast<size_t>(side)];
        if (facing_side == 0) {
            cells.assign(1, unlit);
            continue;
        }
        cells.assign(grid.cellCount(), unlit);
        result.sides[side].n = n;
        result.sides[side].area = triangle.area() / static_cast<float>(cells.size());
        const vec3 n_g = side == 0 ? front : -front;
        grid.forEachCell([&](uint32_t i, const uvec3& c, const vec2& uv) {
            const uint32_t trace = (open[c.x] | open[c.y] | open[c.z]) & facing_side;
            const uint32_t lit = middles.whole[i] & ~trace & facing_side;
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
                const LightSample sample = shared::sampleLight(lights[l], p.position);
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
    return &cells_[side.first + (side.n > 1 ? TriangleGrid{side.n}.placeOf(u, v).cell : 0u)];
}

}  // namespace sheen
