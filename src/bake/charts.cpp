#include "bake/charts.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>
#include <optional>
#include <utility>

#include "bake/atlas.h"
#include "bake/flat.h"
#include "core/directions.h"

namespace sheen {
namespace {

using glm::dvec2;

// Of the chart's first triangle and any other: texels are then a quarter longer at the most than
// they are wide. Of what is unrolled, of neighbours.
constexpr float kLeastCosine = 0.8f;
// Of what is unrolled: the sine of normals above the plane across the axis, and the least one
// between the two normals that tell the axis.
constexpr float kMostTilt = 0.03f;
constexpr float kLeastTurn = 0.01f;
// As many times as much surface as a flat chart holds is worth unrolling.
constexpr double kWorthUnrolling = 2.0;

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

struct Grower {
    const Scene& scene;
    std::vector<uint32_t> places;
    std::vector<vec3> normals;
    std::vector<float> areas;
    std::map<std::pair<uint32_t, uint32_t>, std::vector<uint32_t>> around;  // triangles at an edge
    std::vector<bool> taken;
    double longest = 0.0;  // of what is unrolled: the side of a square of all surface

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
            longest += areas.back();
        }
        longest = std::sqrt(longest);
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

    // From a triangle on, breadth first, as far as a square of that side reaches: neighbours that
    // place(at, edge, next) has corners for. What it takes is taken.
    template <class Place>
    UvChart grow(uint32_t first, const Corners& own, double largest, const Place& place) {
        UvChart chart;
        Flat laid;
        FlatBox around_all(own);
        const auto add = [&](uint32_t i, const Corners& c) {
            taken[i] = true;
            laid.add(c);
            chart.triangles.push_back(i);
            chart.corners.push_back(c);
        };
        add(first, own);
        for (size_t at = 0; at < chart.triangles.size(); ++at) {
            for (int c = 0; c < 3; ++c) {
                for (const uint32_t next : around[edge(chart.triangles[at], c)]) {
                    if (taken[next]) {
                        continue;
                    }
                    const std::optional<Corners> corners = place(chart, at, c, next);
                    if (!corners) {
                        continue;
                    }
                    const FlatBox grown = around_all.with(FlatBox(*corners));
                    if (grown.side() <= largest && laid.free(*corners)) {
                        around_all = grown;
                        add(next, *corners);
                    }
                }
            }
        }
        return chart;
    }

    // What faces about one way, projected onto the plane that the first triangle faces.
    UvChart growFlat(uint32_t first, double largest) {
        const mat3 frame = tangentFrame(normals[first]);
        return grow(first, flat(first, frame), largest,
                    [&](const UvChart&, size_t, int, uint32_t next) -> std::optional<Corners> {
                        if (glm::dot(normals[next], normals[first]) < kLeastCosine) {
                            return std::nullopt;
                        }
                        return flat(next, frame);
                    });
    }

    // What curves about one axis, unrolled: each triangle is turned into the plane about the edge
    // by which it is reached, and keeps its shape.
    UvChart growUnrolled(uint32_t first, const vec3& axis, double largest) {
        const mat3 frame(glm::cross(axis, normals[first]), axis, normals[first]);
        return grow(
            first, flat(first, frame), largest,
            [&](const UvChart& chart, size_t at, int c, uint32_t next) -> std::optional<Corners> {
                const vec3& n = normals[next];
                const bool curves = std::abs(glm::dot(n, axis)) <= kMostTilt &&
                                    glm::dot(n, normals[chart.triangles[at]]) >= kLeastCosine;
                return curves ? unfolded(chart, at, c, next) : std::nullopt;
            });
    }
    // A neighbour across edge c of a triangle of the chart; none where it is wound the other way.
    std::optional<Corners> unfolded(const UvChart& chart, size_t at, int c, uint32_t next) const {
        const uvec3& own = scene.triangles[chart.triangles[at]];
        const uvec3& t = scene.triangles[next];
        const auto begin = static_cast<size_t>(c), end = (begin + 1) % 3;
        for (int k = 0; k < 3; ++k) {
            const int k1 = (k + 1) % 3, k2 = (k + 2) % 3;
            if (places[t[k]] != places[own[(c + 1) % 3]] || places[t[k1]] != places[own[c]]) {
                continue;
            }
            const dvec3 p(scene.positions[t[k]]);
            const dvec3 edge = dvec3(scene.positions[t[k1]]) - p;
            const dvec3 way = dvec3(scene.positions[t[k2]]) - p;
            const dvec2 flat_p = chart.corners[at][end], flat_q = chart.corners[at][begin];
            const dvec2 flat_edge = flat_q - flat_p, left(-flat_edge.y, flat_edge.x);
            const double length2 = glm::dot(edge, edge);
            Corners corners;
            corners[static_cast<size_t>(k)] = flat_p;
            corners[static_cast<size_t>(k1)] = flat_q;
            corners[static_cast<size_t>(k2)] = flat_p + glm::dot(way, edge) / length2 * flat_edge +
                                               glm::length(glm::cross(edge, way)) / length2 * left;
            return corners;
        }
        return std::nullopt;
    }
    // Axes about which the surface may curve at a triangle: by its neighbours' normals.
    std::vector<vec3> axesAt(uint32_t first) const {
        std::vector<vec3> axes;
        for (int c = 0; c < 3; ++c) {
            for (const uint32_t next : around.at(edge(first, c))) {
                const vec3 axis = glm::cross(normals[first], normals[next]);
                if (!taken[next] && glm::length(axis) > kLeastTurn &&
                    glm::dot(normals[first], normals[next]) >= kLeastCosine) {
                    axes.push_back(glm::normalize(axis));
                }
            }
        }
        return axes;
    }
    double areaOf(const UvChart& chart) const {
        return std::accumulate(chart.triangles.begin(), chart.triangles.end(), 0.0,
                               [&](double sum, uint32_t i) { return sum + areas[i]; });
    }
    void take(const UvChart& chart, bool whether) {
        for (const uint32_t i : chart.triangles) {
            taken[i] = whether;
        }
    }
    // Flat, or unrolled where that holds much more.
    UvChart grow(uint32_t first, double largest) {
        UvChart best = growFlat(first, largest);
        take(best, false);
        for (const vec3& axis : axesAt(first)) {
            UvChart unrolled = growUnrolled(first, axis, std::min(largest, longest));
            take(unrolled, false);
            if (areaOf(unrolled) > kWorthUnrolling * areaOf(best)) {
                best = std::move(unrolled);
            }
        }
        take(best, true);
        turn(best, largest);
        return best;
    }
};

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
        }
    }
    return charts;
}

}  // namespace sheen
