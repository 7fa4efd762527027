#include "bake/lightmap.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>
#include <utility>

#include "bake/solids.h"
#include "bake/texels.h"
#include "core/parallel.h"
#include "image/frame.h"

namespace sheen {
namespace {

using glm::dvec2;

// Points that were moved onto a triangle's edge go on toward its middle by this share: on the edge
// itself another surface may begin.
constexpr double kInward = 1e-3;
// Of a texel: what is touched by less is not.
constexpr double kTouch = 1e-3;
// Other points of a texel that are tried, along each side.
constexpr int kTried = 4;

// A triangle in the atlas.
struct FlatTriangle {
    dvec2 corners[3];
    double area2;

    explicit FlatTriangle(const std::array<vec2, 3>& c)
        : corners{dvec2(c[0]), dvec2(c[1]), dvec2(c[2])}, area2(doubleArea(c)) {}

    bool lost() const { return area2 == 0.0; }
    dvec3 barycentric(const dvec2& p) const {
        const double v = cross(p - corners[0], corners[2] - corners[0]) / area2;
        const double w = cross(corners[1] - corners[0], p - corners[0]) / area2;
        return {1.0 - v - w, v, w};
    }
    // Of its nearest point, a little within where that is not p itself.
    dvec3 nearest(const dvec2& p) const {
        const dvec3 own = barycentric(p);
        if (own.x >= 0.0 && own.y >= 0.0 && own.z >= 0.0) {
            return own;
        }
        double least = kInfinity;
        dvec3 best(0.0);
        for (int i = 0; i < 3; ++i) {
            const int j = (i + 1) % 3;
            const dvec2 edge = corners[j] - corners[i];
            const double along =
                glm::clamp(glm::dot(p - corners[i], edge) / glm::dot(edge, edge), 0.0, 1.0);
            const dvec2 way = corners[i] + along * edge - p;
            if (glm::dot(way, way) < least) {
                least = glm::dot(way, way);
                best = dvec3(0.0);
                best[i] = 1.0 - along;
                best[j] = along;
            }
        }
        return glm::mix(best, dvec3(1.0 / 3.0), kInward);
    }
    dvec2 at(const dvec3& b) const {
        return b.x * corners[0] + b.y * corners[1] + b.z * corners[2];
    }
    // Whether it reaches into the square [lower, lower + 1], by separating axes.
    bool touches(const dvec2& lower) const {
        const dvec2 middle = lower + 0.5;
        const double turn = area2 < 0.0 ? -1.0 : 1.0;
        for (int i = 0; i < 3; ++i) {
            const dvec2 edge = corners[(i + 1) % 3] - corners[i];
            const dvec2 inward = turn * dvec2(-edge.y, edge.x);
            const double reach = 0.5 * (std::abs(inward.x) + std::abs(inward.y));
            if (glm::dot(middle - corners[i], inward) + reach < kTouch * glm::length(edge)) {
                return false;
            }
        }
        const dvec2 least = glm::min(glm::min(corners[0], corners[1]), corners[2]);
        const dvec2 most = glm::max(glm::max(corners[0], corners[1]), corners[2]);
        return most.x > lower.x + kTouch && most.y > lower.y + kTouch &&
               least.x < lower.x + 1.0 - kTouch && least.y < lower.y + 1.0 - kTouch;
    }
};

struct Maker {
    const Tracer& tracer;
    const Scene& scene;
    Lightmap& map;
    std::vector<double> distances;  // [texel], of the point from the middle, squared

    explicit Maker(const Tracer& tracer_, Lightmap& map_)
        : tracer(tracer_), scene(tracer_.scene()), map(map_) {}

    // The triangle of each texel: that whose point is nearest to the middle.
    void cover() {
        const int width = map.atlas.size, height = map.atlas.height();
        map.triangles = Image<uint32_t>(width, height, kNoPrimitive);
        distances.assign(map.triangles.pixels.size(), kInfinity);
        const auto texel = [](double v, int count) {
            return glm::clamp(static_cast<int>(std::floor(v)), 0, count - 1);
        };
        for (uint32_t i = 0; i < scene.triangles.size(); ++i) {
            const FlatTriangle flat(map.atlas.corners[i]);
            if (flat.lost()) {
                continue;
            }
            const std::array<vec2, 3>& c = map.atlas.corners[i];
            const int first = texel(std::min({c[0].y, c[1].y, c[2].y}), height);
            const int last = texel(std::max({c[0].y, c[1].y, c[2].y}), height);
            for (int y = first; y <= last; ++y) {
                const dvec2 span = rowSpan(c, y);
                for (int x = texel(span.x, width); span.x <= span.y && x <= texel(span.y, width);
                     ++x) {
                    offer(i, flat, x, y);
                }
            }
        }
    }
    void offer(uint32_t triangle, const FlatTriangle& flat, int x, int y) {
        if (!flat.touches(dvec2(x, y))) {
            return;
        }
        const dvec2 middle(x + 0.5, y + 0.5);
        const dvec2 way = flat.at(flat.nearest(middle)) - middle;
        const auto i =
            static_cast<size_t>(y) * static_cast<size_t>(map.atlas.size) + static_cast<size_t>(x);
        if (glm::dot(way, way) < distances[i]) {
            distances[i] = glm::dot(way, way);
            map.triangles.pixels[i] = triangle;
        }
    }

    struct Point {
        SurfaceSide side;
        vec3 normal;
        float footprint;
    };
    Point pointAt(uint32_t triangle, const dvec3& b) const {
        const uvec3& t = scene.triangles[triangle];
        const dvec3 p0(scene.positions[t.x]), p1(scene.positions[t.y]), p2(scene.positions[t.z]);
        const vec3 position(b.x * p0 + b.y * p1 + b.z * p2);
        const double area2 = glm::length(glm::cross(p1 - p0, p2 - p0));
        const auto footprint = static_cast<float>(
            std::sqrt(area2 / std::abs(doubleArea(map.atlas.corners[triangle]))));
        const vec3 n_g = geometricNormal(scene, static_cast<int>(triangle));
        const SurfaceSide side = sideToward(scene, triangle, position, position + footprint * n_g);
        return {side, normalsAt(scene, triangle, vec3(b), side.n_g, side.toward_viewer).smooth,
                footprint};
    }

    // Where a texel takes its light; none where all of it that is tried is buried.
    std::optional<Point> pointOf(size_t i, const Solids& solids, bool& pushed) const {
        const auto size = static_cast<size_t>(map.atlas.size);
        const dvec2 corner(i % size, i / size);
        const uint32_t triangle = map.triangles.pixels[i];
        const FlatTriangle flat(map.atlas.corners[triangle]);
        const Point own = pointAt(triangle, flat.nearest(corner + 0.5));
        if (!solids.bury(own.side, own.normal)) {
            return own;
        }
        pushed = true;
        std::vector<std::pair<double, dvec3>> others;
        for (int k = 0; k < kTried * kTried; ++k) {
            const dvec2 place = (dvec2(k % kTried, k / kTried) + 0.5) / double{kTried};
            const dvec3 b = flat.barycentric(corner + place);
            if (b.x > 0.0 && b.y > 0.0 && b.z > 0.0) {
                others.emplace_back(glm::length(place - 0.5), b);
            }
        }
        std::stable_sort(others.begin(), others.end(),
                         [](const auto& a, const auto& b) { return a.first < b.first; });
        for (const auto& [distance, b] : others) {
            const Point other = pointAt(triangle, b);
            if (!solids.bury(other.side, other.normal)) {
                return other;
            }
        }
        return std::nullopt;
    }

    void place() {
        const size_t count = map.triangles.pixels.size();
        map.receivers = unseenReceivers(map.atlas.size, map.atlas.height());
        const Receivers& r = map.receivers;
        const Solids solids(tracer);
        std::vector<uint8_t> pushed(count);
        parallelFor(map.atlas.height(), [&](int y) {
            const auto first = static_cast<size_t>(y) * static_cast<size_t>(map.atlas.size);
            for (size_t i = first; i < first + static_cast<size_t>(map.atlas.size); ++i) {
                bool is_pushed = false;
                if (map.triangles.pixels[i] != kNoPrimitive) {
                    set(i, pointOf(i, solids, is_pushed));
                }
                pushed[i] = is_pushed ? 1 : 0;
            }
        });
        for (size_t i = 0; i < count; ++i) {
            map.covered += map.triangles.pixels[i] != kNoPrimitive ? 1 : 0;
            map.pushed += pushed[i] != 0 && r.seen(i) ? 1 : 0;
            map.buried += pushed[i] != 0 && !r.seen(i) ? 1 : 0;
        }
    }
    void set(size_t i, const std::optional<Point>& point) {
        if (!point) {
            return;
        }
        putReceiver(map.receivers, i, scene, map.triangles.pixels[i], point->side, point->normal,
                    point->footprint);
    }
};

}  // namespace

Lightmap lightmapOf(const Tracer& tracer, Atlas atlas) {
    Lightmap map;
    map.atlas = std::move(atlas);
    Maker maker(tracer, map);
    maker.cover();
    maker.place();
    indexReceivers(map.receivers, tracer.scene());
    return map;
}

}  // namespace sheen
