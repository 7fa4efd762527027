#include "light/irradiance_cells.h"

namespace sheen {
namespace {

// How long a cell may be, and how many triangles may be divided into together (gridDivisions()).
constexpr float kLengthOfSize = 1.0f / 128.0f;
constexpr size_t kBudget = 1 << 20;

}  // namespace

IrradianceCells::IrradianceCells(const Scene& scene, const std::vector<Bounds>& near) {
    const std::vector<uint32_t> n = gridDivisions(scene, near, kLengthOfSize, kBudget);
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

}  // namespace sheen
