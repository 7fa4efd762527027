#include "bake/flat.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "bake/atlas.h"

namespace sheen {
namespace {

using glm::dvec2;

// Triangles may reach into each other by so much of the longer side of the rectangle around the
// smaller one: rounding.
constexpr double kAlmostTouch = 1e-5;

// By how much two triangles reach into each other along the edges' normals of the first.
double reachInto(const Corners& a, const Corners& b) {
    const double turn = cross(a[1] - a[0], a[2] - a[0]) < 0.0 ? -1.0 : 1.0;
    double least = kInfinity;
    for (size_t i = 0; i < 3; ++i) {
        const dvec2 edge = a[(i + 1) % 3] - a[i];
        const dvec2 inward = turn * dvec2(-edge.y, edge.x) / glm::length(edge);
        double most = -kInfinity;
        for (const dvec2& p : b) {
            most = std::max(most, glm::dot(p - a[i], inward));
        }
        least = std::min(least, most);
    }
    return least;
}

bool overlap(const Corners& a, const Corners& b) {
    const FlatBox around_a(a), around_b(b);
    if (!around_a.meets(around_b)) {
        return false;
    }
    const double touch = kAlmostTouch * std::min(around_a.side(), around_b.side());
    return reachInto(a, b) > touch && reachInto(b, a) > touch;
}

int levelOf(const FlatBox& box) {
    return std::ilogb(std::max(box.side(), std::numeric_limits<double>::min())) + 1;
}

int64_t keyOf(int64_t x, int64_t y) { return y * (int64_t{1} << 32) + x; }

}  // namespace

struct Flat::Cells {
    std::array<int64_t, 2> lower, upper;

    Cells(const FlatBox& box, int level) {
        constexpr double kFarthest = 1e9;
        const double cell = std::ldexp(1.0, level);
        const auto at = [&](double v) {
            return static_cast<int64_t>(std::floor(glm::clamp(v / cell, -kFarthest, kFarthest)));
        };
        lower = {at(box.lower.x), at(box.lower.y)};
        upper = {at(box.upper.x), at(box.upper.y)};
    }
    double count() const {
        return static_cast<double>(upper[0] - lower[0] + 1) *
               static_cast<double>(upper[1] - lower[1] + 1);
    }
};

bool Flat::free(const Corners& c) const {
    const FlatBox box(c);
    for (const auto& [level, grid] : grids_) {
        if (!free(c, Cells(box, level), grid)) {
            return false;
        }
    }
    return true;
}

void Flat::add(const Corners& c) {
    const FlatBox box(c);
    const int level = levelOf(box);
    const auto index = static_cast<uint32_t>(placed_.size());
    Grid& grid = grids_[level];
    grid.all.push_back(index);
    const Cells cells(box, level);
    for (int64_t y = cells.lower[1]; y <= cells.upper[1]; ++y) {
        for (int64_t x = cells.lower[0]; x <= cells.upper[0]; ++x) {
            grid.cells[keyOf(x, y)].push_back(index);
        }
    }
    placed_.push_back(c);
}

bool Flat::free(const Corners& c, const std::vector<uint32_t>& others) const {
    return std::none_of(others.begin(), others.end(),
                        [&](uint32_t i) { return overlap(c, placed_[i]); });
}

bool Flat::free(const Corners& c, const Cells& cells, const Grid& grid) const {
    if (cells.count() > static_cast<double>(grid.all.size()) + 4.0) {
        return free(c, grid.all);  // it is larger than all that is there together
    }
    for (int64_t y = cells.lower[1]; y <= cells.upper[1]; ++y) {
        for (int64_t x = cells.lower[0]; x <= cells.upper[0]; ++x) {
            const auto found = grid.cells.find(keyOf(x, y));
            if (found != grid.cells.end() && !free(c, found->second)) {
                return false;
            }
        }
    }
    return true;
}

}  // namespace sheen
