#include "bake/atlas.h"

#include <stb_rect_pack.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numeric>
#include <span>
#include <tuple>
#include <utility>

#include "bake/charts.h"
#include "core/error.h"
#include "core/memory.h"

namespace sheen {
namespace {

constexpr uint32_t kNone = ~0u;

double areaOf(const Scene& scene, const uvec3& t) {
    const vec3& p = scene.positions[t.x];
    return 0.5 *
           glm::length(glm::dvec3(glm::cross(scene.positions[t.y] - p, scene.positions[t.z] - p)));
}

// Whole texels, so that a chart's borders, where they lie along its rectangle, are theirs.
ivec2 texelsOf(const UvChart& chart, double density) {
    const glm::dvec2 size = glm::ceil(chart.extent * density - 1e-4);
    return glm::clamp(ivec2(glm::min(size, glm::dvec2(2.0 * kLargestAtlas))), 1, 2 * kLargestAtlas);
}

// With those that stay free around it.
int64_t texelCount(const UvChart& chart, double density) {
    const ivec2 texels = texelsOf(chart, density) + 2 * kPadding;
    return int64_t{texels.x} * texels.y;
}

// Where the charts lie at so many texels a unit, in order; empty where they do not fit.
std::vector<ivec2> pack(std::span<const UvChart> charts, double density, int size) {
    std::vector<stbrp_rect> rects(charts.size());
    int64_t left = int64_t{size} * size;
    for (size_t i = 0; i < charts.size(); ++i) {
        const ivec2 texels = texelsOf(charts[i], density) + 2 * kPadding;
        left -= int64_t{texels.x} * texels.y;
        if (texels.x > size || texels.y > size || left < 0) {
            return {};
        }
        rects[i] = {.id = static_cast<int>(i),
                    .w = texels.x,
                    .h = texels.y,
                    .x = 0,
                    .y = 0,
                    .was_packed = 0};
    }
    std::vector<stbrp_node> nodes(static_cast<size_t>(size));
    stbrp_context context;
    stbrp_init_target(&context, size, size, nodes.data(), size);
    if (stbrp_pack_rects(&context, rects.data(), static_cast<int>(rects.size())) == 0) {
        return {};
    }
    std::vector<ivec2> places(charts.size());
    for (const stbrp_rect& r : rects) {
        places[static_cast<size_t>(r.id)] = ivec2(r.x, r.y) + kPadding;
    }
    return places;
}

// The greatest density at which they fit, to within a hundredth; 0 where none does.
double densestFor(const std::vector<UvChart>& charts, double area, int size) {
    double high = size / std::sqrt(area);
    double low = high;
    constexpr double kLeast = 1e-6;  // every chart is one texel then
    while (pack(charts, low, size).empty()) {
        if (low < kLeast * high) {
            return 0.0;
        }
        low *= 0.5;
    }
    high = std::min(high, 2.0 * low);
    while (high > 1.01 * low) {
        const double middle = std::sqrt(low * high);
        (pack(charts, middle, size).empty() ? high : low) = middle;
    }
    return low;
}

// Charts with their places.
struct Packing {
    int size = 0;
    double density = 0.0;
    std::vector<UvChart> charts = {};
    std::vector<ivec2> places = {};  // [chart], on its page
    std::vector<int> page_of = {};   // [chart]; pages are filled one after the other
};

Packing onOnePage(std::vector<UvChart> charts, int size, double density) {
    Packing packing{.size = size, .density = density};
    packing.places = pack(charts, density, size);
    packing.page_of.assign(packing.places.size(), 0);
    packing.charts = std::move(charts);
    return packing;
}

// To three digits, and no more than that.
double roundedDown(double value) {
    const double unit = std::pow(10.0, std::floor(std::log10(value)) - 2.0);
    return std::floor(value / unit) * unit;
}

// Charts whose texels alone take more than there may be. Rows are counted by floats, to a 64th of a
// texel.
void checkPages(const std::vector<UvChart>& charts, int size, double density) {
    constexpr int64_t kMostTexels = int64_t{1} << 30;
    constexpr int64_t kMostRows = int64_t{1} << 17;
    const int64_t page = int64_t{size} * size;
    const int64_t most = std::min(kMostTexels / page, kMostRows / size);
    int64_t texels = 0;
    for (const UvChart& chart : charts) {
        texels += texelCount(chart, density);
        if (texels > most * page) {
            throwUsage(
                "--texels-per-metre {}: takes more than {} lightmaps of {} x {} texels; ask for "
                "fewer{}",
                static_cast<float>(density), most, size, size,
                size < kLargestAtlas ? ", or for a larger --size" : "");
        }
    }
}

// How many of the first charts a page holds: no more than have as many texels, and by bisection,
// which is right up to what packing happens to lose.
size_t fitting(std::span<const UvChart> charts, double density, int size) {
    size_t fits = 0, too_many = 0;
    for (int64_t left = int64_t{size} * size; left >= 0; ++too_many) {
        left -= too_many < charts.size() ? texelCount(charts[too_many], density) : left + 1;
    }
    while (fits + 1 < too_many) {
        const size_t middle = std::midpoint(fits, too_many);
        (pack(charts.first(middle), density, size).empty() ? too_many : fits) = middle;
    }
    return fits;
}

void sortByFirstTriangle(std::vector<UvChart>& charts) {
    std::vector<std::pair<uint32_t, size_t>> order;
    for (size_t i = 0; i < charts.size(); ++i) {
        const auto& own = charts[i].triangles;
        order.emplace_back(*std::min_element(own.begin(), own.end()), i);
    }
    std::sort(order.begin(), order.end());
    std::vector<UvChart> sorted;
    sorted.reserve(charts.size());
    for (const auto& [triangle, i] : order) {
        sorted.push_back(std::move(charts[i]));
    }
    charts.swap(sorted);
}

// In the order of the file's primitives, so that each of these is on few pages.
Packing onPages(const Scene& scene, int size, double density) {
    Packing packing{.size = size, .density = density};
    std::vector<UvChart>& charts = packing.charts;
    double widest = 0.0;
    const double largest = (size - 2 * kPadding) / density;
    charts = makeCharts(scene, largest);
    for (const UvChart& chart : charts) {
        widest = std::max({widest, chart.extent.x, chart.extent.y});
    }
    if (widest > largest) {
        throwUsage(
            "--texels-per-metre {}: a triangle of {:.3g} m takes more than {} x {} texels; ask for "
            "at most {:.3g}{}",
            static_cast<float>(density), widest, size, size,
            roundedDown(density * largest / widest),
            size < kLargestAtlas ? ", or for a larger --size" : "");
    }
    checkPages(charts, size, density);
    sortByFirstTriangle(charts);
    for (int page = 0; packing.places.size() < charts.size(); ++page) {
        const auto left = std::span<const UvChart>(charts).subspan(packing.places.size());
        const size_t count = fitting(left, density, size);
        const std::vector<ivec2> places = pack(left.first(count), density, size);
        packing.places.insert(packing.places.end(), places.begin(), places.end());
        packing.page_of.insert(packing.page_of.end(), count, page);
    }
    return packing;
}

Packing choosePacking(const Scene& scene, const AtlasParams& params) {
    std::vector<UvChart> charts = makeCharts(scene);
    const double asked = params.texels_per_metre;
    if (asked == 0.0) {
        double area = 0.0;
        for (const uvec3& t : scene.triangles) {
            area += areaOf(scene, t);
        }
        const double density = densestFor(charts, area, params.size);
        if (density == 0.0) {
            throwUsage(
                "--size {}: too small: the scene falls into {} charts, which take a texel each and "
                "{} around them; ask for a larger one",
                params.size, charts.size(), kPadding);
        }
        return onOnePage(std::move(charts), params.size, density);
    }
    constexpr int kLeastMade = 64;
    const int largest = params.size > 0 ? params.size : kLargestAtlas;
    for (int size = params.size > 0 ? params.size : kLeastMade; size <= largest; size *= 2) {
        if (!pack(charts, asked, size).empty()) {
            return onOnePage(std::move(charts), size, asked);
        }
    }
    return onPages(scene, largest, asked);
}

// The first triangle whose coordinates lie outside of the unit square or have no area.
std::string badTriangle(const Scene& scene) {
    constexpr float kRounding = 1e-5f;
    for (size_t i = 0; i < scene.triangles.size(); ++i) {
        std::array<vec2, 3> c;
        for (size_t k = 0; k < 3; ++k) {
            c[k] = scene.second_uvs[scene.triangles[i][static_cast<int>(k)]];
            if (c[k].x < -kRounding || c[k].y < -kRounding || c[k].x > 1.0f + kRounding ||
                c[k].y > 1.0f + kRounding) {
                return fmt::format("triangle {} reaches out of the unit square", i);
            }
        }
        if (!(std::abs(doubleArea(c)) > 0.0)) {
            return fmt::format("triangle {} has no area there", i);
        }
    }
    return {};
}

// Whether two triangles have the middle of one texel within them.
std::string overlapIn(const Atlas& atlas) {
    constexpr double kInside = 1e-4;  // of a texel, from each edge
    const auto size = static_cast<size_t>(atlas.size);
    std::vector<uint32_t> owner(size * size, kNone);
    for (size_t i = 0; i < atlas.corners.size(); ++i) {
        const std::array<vec2, 3>& c = atlas.corners[i];
        const double turn = doubleArea(c) < 0.0 ? -1.0 : 1.0;
        const auto texel = [&](double v) {
            return glm::clamp(static_cast<int>(std::floor(v)), 0, atlas.size - 1);
        };
        const int first = texel(std::min({c[0].y, c[1].y, c[2].y}));
        const int last = texel(std::max({c[0].y, c[1].y, c[2].y}));
        for (int y = first; y <= last; ++y) {
            const glm::dvec2 span = rowSpan(c, y);
            for (int x = texel(span.x); span.x <= span.y && x <= texel(span.y); ++x) {
                bool inside = true;
                for (size_t k = 0; k < 3; ++k) {
                    const glm::dvec2 a(c[k]), b(c[(k + 1) % 3]);
                    const glm::dvec2 edge = b - a, way = glm::dvec2(x + 0.5, y + 0.5) - a;
                    inside = inside &&
                             turn * (edge.x * way.y - edge.y * way.x) > kInside * glm::length(edge);
                }
                if (!inside) {
                    continue;
                }
                uint32_t& own = owner[static_cast<size_t>(y) * size + static_cast<size_t>(x)];
                if (own != kNone) {
                    return fmt::format("triangles {} and {} lie over each other at texel {}, {}",
                                       own, i, x, y);
                }
                own = static_cast<uint32_t>(i);
            }
        }
    }
    return {};
}

// Triangles that share a corner, in space and in the atlas, share a chart.
void numberCharts(const Scene& scene, Atlas& atlas) {
    const std::vector<uint32_t> places = placesOf(scene);
    std::map<std::tuple<uint32_t, float, float>, uint32_t> corner_of;
    std::vector<uint32_t> root;
    const auto find = [&](uint32_t i) {
        while (root[i] != i) {
            i = root[i] = root[root[i]];
        }
        return i;
    };
    std::vector<uint32_t> first;  // [triangle]
    for (size_t i = 0; i < scene.triangles.size(); ++i) {
        for (size_t k = 0; k < 3; ++k) {
            const vec2& c = atlas.corners[i][k];
            const auto next = static_cast<uint32_t>(root.size());
            const auto [found, is_new] = corner_of.emplace(
                std::tuple(places[scene.triangles[i][static_cast<int>(k)]], c.x, c.y), next);
            if (is_new) {
                root.push_back(next);
            }
            if (k == 0) {
                first.push_back(found->second);
            } else {
                root[find(found->second)] = find(first.back());
            }
        }
    }
    std::vector<uint32_t> number(root.size(), kNone);
    for (const uint32_t corner : first) {
        uint32_t& own = number[find(corner)];
        if (own == kNone) {
            own = static_cast<uint32_t>(atlas.charts++);
        }
        atlas.chart_of.push_back(own);
    }
}

void checkTexels(const Atlas& atlas) {
    constexpr uint64_t kBytesPerTexel = 256;  // receivers, their index, sums, images
    const std::string what =
        atlas.pages == 1
            ? fmt::format("a lightmap of {} x {} texels", atlas.size, atlas.size)
            : fmt::format("{} lightmaps of {} x {} texels", atlas.pages, atlas.size, atlas.size);
    checkMemory({.bytes = kBytesPerTexel * static_cast<uint64_t>(atlas.size) *
                          static_cast<uint64_t>(atlas.height())},
                what,
                atlas.pages == 1 ? "ask for a smaller --size or fewer --texels-per-metre"
                                 : "ask for fewer --texels-per-metre");
}

}  // namespace

Atlas atlasOfFile(const Scene& scene, const AtlasParams& params, std::string& why) {
    why = scene.second_uvs.empty() ? "there are none" : badTriangle(scene);
    if (!why.empty()) {
        return {};
    }
    Atlas atlas;
    atlas.of_file = true;
    atlas.page_of.assign(scene.triangles.size(), 0);
    atlas.size = params.size;
    if (params.texels_per_metre > 0.0f) {
        double in_scene = 0.0, in_square = 0.0;
        for (const uvec3& t : scene.triangles) {
            in_scene += areaOf(scene, t);
            in_square += 0.5 * std::abs(doubleArea({scene.second_uvs[t.x], scene.second_uvs[t.y],
                                                    scene.second_uvs[t.z]}));
        }
        const double side = params.texels_per_metre * std::sqrt(in_scene / in_square);
        if (side > (params.size > 0 ? params.size : kLargestAtlas)) {
            why = fmt::format("by them {} texels a metre take {:.0f} x {:.0f}, more than {}",
                              params.texels_per_metre, side, side,
                              params.size > 0 ? params.size : kLargestAtlas);
            return {};
        }
        atlas.size = params.size > 0 ? params.size
                                     : std::max(static_cast<int>(std::ceil(side)), kLeastAtlas);
    }
    checkTexels(atlas);
    const auto scale = static_cast<float>(atlas.size);
    for (const uvec3& t : scene.triangles) {
        atlas.corners.push_back({scale * scene.second_uvs[t.x], scale * scene.second_uvs[t.y],
                                 scale * scene.second_uvs[t.z]});
    }
    why = overlapIn(atlas);
    if (!why.empty()) {
        return {};
    }
    numberCharts(scene, atlas);
    return atlas;
}

Atlas makeAtlas(const Scene& scene, const AtlasParams& params) {
    const Packing packing = choosePacking(scene, params);
    const std::vector<UvChart>& charts = packing.charts;
    Atlas atlas;
    atlas.size = packing.size;
    atlas.pages = packing.page_of.back() + 1;
    atlas.charts = static_cast<int>(charts.size());
    checkTexels(atlas);
    atlas.corners.resize(scene.triangles.size());
    atlas.chart_of.resize(scene.triangles.size());
    atlas.page_of.resize(scene.triangles.size());
    for (size_t i = 0; i < charts.size(); ++i) {
        const glm::dvec2 scale =
            glm::dvec2(texelsOf(charts[i], packing.density)) /
            glm::max(charts[i].extent, glm::dvec2(std::numeric_limits<float>::min()));
        const ivec2 place = packing.places[i] + ivec2(0, packing.page_of[i] * packing.size);
        for (size_t k = 0; k < charts[i].triangles.size(); ++k) {
            const uint32_t triangle = charts[i].triangles[k];
            atlas.chart_of[triangle] = static_cast<uint32_t>(i);
            atlas.page_of[triangle] = packing.page_of[i];
            for (size_t c = 0; c < 3; ++c) {
                atlas.corners[triangle][c] =
                    vec2(glm::dvec2(place) + scale * charts[i].corners[k][c]);
            }
        }
    }
    return atlas;
}

Atlas atlasOf(const Scene& scene, const AtlasParams& params) {
    if (scene.triangles.empty()) {
        throwInput("the scene has no geometry: there is nothing to bake");
    }
    std::string why;
    Atlas atlas = atlasOfFile(scene, params, why);
    if (!why.empty()) {
        if (!scene.second_uvs.empty()) {
            warn(
                fmt::format("the file's second texture coordinates will not do for a lightmap: "
                            "{}; charts are made instead",
                            why));
        }
        atlas = makeAtlas(scene, params);
    }
    return atlas;
}

}  // namespace sheen
