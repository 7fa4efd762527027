// Triangles divided into small cells, on which light is found once for all rays that meet them.
#pragma once

#include <algorithm>
#include <vector>

#include "scene/scene.h"

namespace sheen {

/// A triangle's first corner and its edges from there.
struct TriangleEdges {
    vec3 p0, e1, e2;

    TriangleEdges(const Scene& scene, uint32_t index) {
        const uvec3& t = scene.triangles[index];
        p0 = scene.positions[t.x];
        e1 = scene.positions[t.y] - p0;
        e2 = scene.positions[t.z] - p0;
    }
    /// At Embree's barycentric coordinates.
    vec3 at(const vec2& uv) const { return p0 + uv.x * e1 + uv.y * e2; }
    float longestEdge() const {
        return std::max({glm::length(e1), glm::length(e2), glm::length(e2 - e1)});
    }
    float area() const { return 0.5f * glm::length(glm::cross(e1, e2)); }
};

/// A triangle whose edges are divided n times: n^2 cells, in rows of constant v. A row alternates
/// between cells that point as the triangle does and cells between two of those.
struct TriangleGrid {
    uint32_t n;

    size_t cellCount() const { return size_t{n} * n; }
    size_t cornerCount() const { return size_t{n + 1} * (n + 2) / 2; }
    uint32_t firstOfRow(uint32_t j) const { return j * (2 * n - j); }
    uint32_t corner(uint32_t i, uint32_t j) const { return j * (2 * n + 3 - j) / 2 + i; }

    /// body(cell, its three corners, (u, v) of its middle)
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
    /// The cell of a point, and its middle.
    struct Place {
        uint32_t cell;
        vec2 middle;
        float scale;  ///< its edges over the triangle's, negative where it points the other way

        /// A place evenly spread over the cell by two random numbers.
        vec2 spread(const vec2& u) const {
            const vec2 uv = u.x + u.y < 1.0f ? u : 1.0f - u;
            return middle + scale * (uv - 1.0f / 3.0f);
        }
    };
    Place placeOf(float u, float v) const {
        const float x = std::max(u * static_cast<float>(n), 0.0f);
        const float y = std::max(v * static_cast<float>(n), 0.0f);
        const uint32_t j = std::min(static_cast<uint32_t>(y), n - 1);
        const uint32_t i = std::min(static_cast<uint32_t>(x), n - 1 - j);
        const bool between =
            i + j + 1 < n && x - static_cast<float>(i) + y - static_cast<float>(j) > 1.0f;
        const float scale = 1.0f / static_cast<float>(n);
        return {.cell = firstOfRow(j) + 2 * i + (between ? 1 : 0),
                .middle = scale * (vec2(i, j) + (between ? 2.0f : 1.0f) / 3.0f),
                .scale = between ? -scale : scale};
    }
};

/// How often a triangle's edges are divided, of each triangle: into cells as long as `share` of the
/// size of the scene, or of the least box of `near` that the triangle reaches into, but an edge no
/// more often than one as long as the box is; where there would be more than `budget` cells, all
/// less often by one factor.
std::vector<uint32_t> gridDivisions(const Scene& scene, const std::vector<Bounds>& near,
                                    float share, size_t budget);

}  // namespace sheen
