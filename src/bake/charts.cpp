#include "bake/charts.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <unordered_map>

#include "bake/atlas.h"
#include "core/directions.h"

namespace sheen {
namespace {

using glm::dvec2;

using Corners = std::array<dvec2, 3>;

// Of the chart's first triangle and any other: texels are then a quarter longer at the most than
// they are wide.
constexpr float kLeastCosine = 0.8f;
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

struct Box {
    dvec2 lower, upper;

    explicit Box(const Corners& c)
        : lower(glm::min(glm::min(c[0], c[1]), c[2])),
          upper(glm::max(glm::max(c[0], c[1]), c[2])) {}
    double side() const { return std::max(upper.x - lower.x, upper.y - lower.y); }
    Box with(const Box& other) const {
        Box both = *this;
        both.lower = glm::min(lower, other.lower);
        both.upper = glm::max(upper, other.upper);
        return both;
    }
    bool meets(const Box& other) const {
        return lower.x < other.upper.x && other.lower.x < upper.x && lower.y < other.upper.y &&
               other.lower.y < upper.y;
    }
};

bool overlap(const Corners& a, const Corners& b) {
    const Box around_a(a), around_b(b);
    if (!around_a.meets(around_b)) {
        return false;
    }
    const double touch = kAlmostTouch * std::min(around_a.side(), around_b.side());
    return reachInto(a, b) > touch && reachInto(b, a) > touch;
}

// Triangles of a chart as they are laid flat, found by where they lie. Each is kept in a grid whose
// cells are as large as itself, within a factor of two, so that it lies in four of them at the
// most: however sizes differ, none fills many cells, and no cell holds many of much less than its
// size.
class Flat {
  public:
    bool free(const Corners& c) const {
        const Box box(c);
        for (const auto& [level, grid] : grids_) {
            if (!free(c, cellsOf(box, level), grid)) {
                return false;
            }
        }
        return true;
    }
    void add(const Corners& c) {
        const Box box(c);
        const int level = levelOf(box);
        const auto index = static_cast<uint32_t>(placed_.size());
        Grid& grid = grids_[level];
        grid.all.push_back(index);
        const Cells cells = cellsOf(box, level);
        for (int64_t y = cells.lower[1]; y <= cells.upper[1]; ++y) {
            for (int64_t x = cells.lower[0]; x <= cells.upper[0]; ++x) {
                grid.cells[keyOf(x, y)].push_back(index);
            }
        }
        placed_.push_back(c);
    }

  private:
    struct Grid {
        std::vector<uint32_t> all;
        std::unordered_map<int64_t, std::vector<uint32_t>> cells;
    };
    struct Cells {
        std::array<int64_t, 2> lower, upper;
        double count() const {
            return static_cast<double>(upper[0] - lower[0] + 1) *
                   static_cast<double>(upper[1] - lower[1] + 1);
        }
    };

    static int levelOf(const Box& box) {
        return std::ilogb(std::max(box.side(), std::numeric_limits<double>::min())) + 1;
    }
    static Cells cellsOf(const Box& box, int level) {
        constexpr double kFarthest = 1e9;
        const double cell = std::ldexp(1.0, level);
        const auto at = [&](double v) {
            return static_cast<int64_t>(std::floor(glm::clamp(v / cell, -kFarthest, kFarthest)));
        };
        return {{at(box.lower.x), at(box.lower.y)}, {at(box.upper.x), at(box.upper.y)}};
    }
    static int64_t keyOf(int64_t x, int64_t y) { return y * (int64_t{1} << 32) + x; }

    bool free(const Corners& c, const std::vector<uint32_t>& others) const {
        return std::none_of(others.begin(), others.end(),
                            [&](uint32_t i) { return overlap(c, placed_[i]); });
    }
    bool free(const Corners& c, const Cells& cells, const Grid& grid) const {
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

    std::vector<Corners> placed_;
    std::map<int, Grid> grids_;  // by the cells' size: a power of two
};

struct Grower {
    const Scene& scene;
    std::vector<uint32_t> places;
    std::vector<vec3> normals;
    std::vector<float> areas;
    std::map<std::pair<uint32_t, uint32_t>, std::vector<uint32_t>> around;  // triangles at an edge
    std::vector<bool> taken;

    explicit Grower(const Scene& scene_) : scene(scene_), places(placesOf(scene_)) {
        const size_t count = scene.triangles.size();
        taken.resize(count);
        for (uint32_t i = 0; i < count; ++i) {
            const uvec3& t = scene.triangles[i];
            normals.push_back(geometricNormal(scene, static_cast<int>(i)));
            areas.push_back(0.5f *
                            glm::length(glm::cross(scene.positions[t.y] - scene.positions[t.x],
                                                   scene.positions[t.z] - scene.positions[t.x])));
            for (int c = 0; c < 3; ++c) {
                around[edge(i, c)].push_back(i);
            }
        }
    }
    std::pair<uint32_t, uint32_t> edge(uint32_t triangle, int c) const {
        const uvec3& t = scene.triangles[triangle];
        return std::minmax({places[t[c]], places[t[(c + 1) % 3]]});
    }
    Corners flat(uint32_t triangle, const mat3& frame) const {
        Corners c;
        for (size_t k = 0; k < 3; ++k) {
            const dvec3 p(scene.positions[scene.triangles[triangle][static_cast<int>(k)]]);
            c[k] = dvec2(glm::dot(p, dvec3(frame[0])), glm::dot(p, dvec3(frame[1])));
        }
        return c;
    }

    // From a triangle on, breadth first, as far as a square of that side reaches.
    UvChart grow(uint32_t first, double largest) {
        const mat3 frame = tangentFrame(normals[first]);
        UvChart chart;
        const auto add = [&](uint32_t i, const Corners& c) {
            taken[i] = true;
            chart.triangles.push_back(i);
            chart.corners.push_back(c);
        };
        const Corners own = flat(first, frame);
        Flat laid;
        laid.add(own);
        add(first, own);
        Box around_all(own);
        for (size_t at = 0; at < chart.triangles.size(); ++at) {
            for (int c = 0; c < 3; ++c) {
                for (const uint32_t next : around[edge(chart.triangles[at], c)]) {
                    if (taken[next] || glm::dot(normals[next], normals[first]) < kLeastCosine) {
                        continue;
                    }
                    const Corners corners = flat(next, frame);
                    const Box grown = around_all.with(Box(corners));
                    if (grown.side() <= largest && laid.free(corners)) {
                        around_all = grown;
                        laid.add(corners);
                        add(next, corners);
                    }
                }
            }
        }
        return chart;
    }
};

// Counter-clockwise; by Andrew's monotone chain.
std::vector<dvec2> convexHull(std::vector<dvec2> points) {
    const auto before = [](const dvec2& a, const dvec2& b) {
        return a.x < b.x || (a.x == b.x && a.y < b.y);
    };
    std::sort(points.begin(), points.end(), before);
    std::vector<dvec2> hull;
    for (int half = 0; half < 2; ++half) {
        const size_t start = hull.size();
        for (const dvec2& p : points) {
            while (hull.size() >= start + 2 &&
                   cross(hull.back() - hull[hull.size() - 2], p - hull.back()) <= 0.0) {
                hull.pop_back();
            }
            hull.push_back(p);
        }
        hull.pop_back();
        std::reverse(points.begin(), points.end());
    }
    return hull;
}

// Turned so that the rectangle around it is as small as it may be: one of the hull's edges lies
// along it. Where none of these is within the largest side, it stays as it was laid.
void turn(UvChart& chart, double largest) {
    std::vector<dvec2> points;
    for (const Corners& c : chart.corners) {
        points.insert(points.end(), c.begin(), c.end());
    }
    const std::vector<dvec2> hull = convexHull(std::move(points));
    double least = kInfinity;
    dvec2 best_along(1.0, 0.0), best_lower(0.0);
    const auto offer = [&](const dvec2& along, double beyond) {
        dvec2 lower(kInfinity), upper(-kInfinity);
        for (const dvec2& p : hull) {
            const dvec2 q(glm::dot(p, along), cross(along, p));
            lower = glm::min(lower, q);
            upper = glm::max(upper, q);
        }
        const dvec2 extent = upper - lower;
        const double area = extent.x * extent.y;
        if (std::max(extent.x, extent.y) <= beyond && area < least * (1.0 - 1e-9)) {
            least = area;
            best_along = along;
            best_lower = lower;
            chart.extent = extent;
        }
    };
    for (size_t i = 0; i < hull.size(); ++i) {
        const dvec2 edge = hull[(i + 1) % hull.size()] - hull[i];
        if (glm::length(edge) > 0.0) {
            offer(glm::normalize(edge), largest);
        }
    }
    if (least == kInfinity) {
        offer(best_along, kInfinity);
    }
    for (Corners& c : chart.corners) {
        for (dvec2& p : c) {
            p = dvec2(glm::dot(p, best_along), cross(best_along, p)) - best_lower;
        }
    }
}

}  // namespace

std::vector<uint32_t> placesOf(const Scene& scene) {
    std::vector<uint32_t> order(scene.positions.size());
    std::iota(order.begin(), order.end(), 0u);
    const auto key = [&](uint32_t i) {
        const vec3& p = scene.positions[i];
        return std::array<float, 3>{p.x, p.y, p.z};
    };
    std::sort(order.begin(), order.end(),
              [&](uint32_t a, uint32_t b) { return std::pair(key(a), a) < std::pair(key(b), b); });
    std::vector<uint32_t> places(order.size());
    for (size_t k = 0; k < order.size(); ++k) {
        const bool same = k > 0 && key(order[k]) == key(order[k - 1]);
        places[order[k]] = same ? places[order[k - 1]] : order[k];
    }
    return places;
}

std::vector<UvChart> makeCharts(const Scene& scene, double largest) {
    Grower grower(scene);
    std::vector<uint32_t> order(scene.triangles.size());
    std::iota(order.begin(), order.end(), 0u);
    std::stable_sort(order.begin(), order.end(),
                     [&](uint32_t a, uint32_t b) { return grower.areas[a] > grower.areas[b]; });
    std::vector<UvChart> charts;
    for (const uint32_t i : order) {
        if (!grower.taken[i]) {
            charts.push_back(grower.grow(i, largest));
            turn(charts.back(), largest);
        }
    }
    return charts;
}

}  // namespace sheen
