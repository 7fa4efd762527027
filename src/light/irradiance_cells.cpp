#include "light/irradiance_cells.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "rays/surface_point.h"

namespace sheen {
namespace {

// How long a cell may be, and how many triangles may be divided into together (gridDivisions()).
constexpr float kIrradianceCellOfSize = 1.0f / 128.0f;
constexpr size_t kMostIrradianceCells = 1 << 20;

}  // namespace

IrradianceCells::IrradianceCells(const Tracer& tracer, const std::vector<Bounds>& near)
    : tracer_(tracer) {
    const Scene& scene = tracer.scene();
    const std::vector<uint32_t> n =
        gridDivisions(scene, near, kIrradianceCellOfSize, kMostIrradianceCells);
    size_t count = 0;
    triangles_.reserve(n.size());
    for (size_t i = 0; i < n.size(); ++i) {
        const size_t cells = TriangleGrid{n[i]}.cellCount();
        triangles_.push_back({.first = static_cast<uint32_t>(count),
                              .n = n[i],
                              .cell_area = TriangleEdges(scene, static_cast<uint32_t>(i)).area() /
                                           static_cast<float>(cells)});
        count += 2 * cells;
    }
    cells_ = std::make_unique<std::atomic<uint64_t>[]>(count);
    for (size_t i = 0; i < count; ++i) {
        cells_[i].store(kUnknown, std::memory_order_relaxed);
    }
}

// Whether something hides the cell's corners from its middle.
bool IrradianceCells::parted(const Hit& hit, const Cell& cell) const {
    // A little within, so that what only touches the cell does not count.
    constexpr float kWithin = 0.98f;
    constexpr vec2 kCorners[] = {{0, 0}, {1, 0}, {0, 1}};
    const Scene& scene = tracer_.scene();
    const vec3 front = geometricNormal(scene, static_cast<int>(hit.triangle));
    const vec3 n = hit.back ? -front : front;
    const TriangleEdges triangle(scene, hit.triangle);
    const float edge = triangle.longestEdge() * std::abs(cell.scale);
    const auto startAt = [&](const vec2& uv) {
        const vec3 p = triangle.at(uv);
        return p + surfaceOffset(scene, hit.triangle, p, n, edge) * n;
    };
    const vec3 middle = startAt(cell.middle);
    std::array<Way, std::size(kCorners)> ways;
    for (size_t i = 0; i < ways.size(); ++i) {
        const vec3 way = startAt(cell.middle + cell.scale * (kCorners[i] - 1.0f / 3.0f)) - middle;
        const float length = glm::length(way);
        ways[i] = {.start = middle, .direction = way / length, .length = kWithin * length};
    }
    const Tracer::Shares shares = tracer_.passing(ways);
    return std::any_of(shares.begin(), shares.begin() + ways.size(),
                       [](const vec3& share) { return share == vec3(0.0f); });
}

}  // namespace sheen
