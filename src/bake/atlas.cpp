#include "bake/atlas.h"

#include <stb_rect_pack.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <tuple>

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

// Where the charts lie at so many texels a unit, in order; empty where they do not fit.
std::vector<ivec2> pack(const std::vector<UvChart>& charts, double density, int size) {
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

struct Packing {
    int size = 0;
    double density = 0.0;
};

Packing choosePacking(const std::vector<UvChart>& charts, double area, const AtlasParams& params) {
    const double asked = params.texels_per_metre;
    if (asked == 0.0) {
        const Packing packing{params.size, densestFor(charts, area, params.size)};
        if (packing.density == 0.0) {
            throwUsage(
                "--size {}: too small: the scene falls into {} charts, which take a texel each and "
                "{} around them; ask for a larger one",
                params.size, charts.size(), kPadding);
        }
        return packing;
    }
    if (params.size > 0) {
        if (pack(charts, asked, params.size).empty()) {
            const double most = densestFor(charts, area, params.size);
            throwUsage(
                "--size {}: too small for {} texels a metre; ask for at most {:.3g}, or for a "
                "larger size",
                params.size, asked, most);
        }
        return {params.size, asked};
    }
    for (int size = 64; size <= kLargestAtlas; size *= 2) {
        if (!pack(charts, asked, size).empty()) {
            return {size, asked};
        }
    }
    throwUsage("--texels-per-metre {}: takes more than {} x {} texels; ask for at most {:.3g}",
               asked, kLargestAtlas, kLargestAtlas, densestFor(charts, area, kLargestAtlas));
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

void checkTexels(int size) {
    constexpr uint64_t kBytesPerTexel = 256;  // receivers, their index, sums, images
    const auto side = static_cast<uint64_t>(size);
    checkMemory({.bytes = kBytesPerTexel * side * side},
                fmt::format("a lightmap of {} x {} texels", size, size),
                "ask for a smaller --size or fewer --texels-per-metre");
}

}  // namespace

Atlas atlasOfFile(const Scene& scene, const AtlasParams& params, std::string& why) {
    why = scene.second_uvs.empty() ? "there are none" : badTriangle(scene);
    if (!why.empty()) {
        return {};
    }
    Atlas atlas;
    atlas.of_file = true;
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
    checkTexels(atlas.size);
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
    const std::vector<UvChart> charts = makeCharts(scene);
    double area = 0.0;
    for (const uvec3& t : scene.triangles) {
        area += areaOf(scene, t);
    }
    const Packing packing = choosePacking(charts, area, params);
    checkTexels(packing.size);
    const std::vector<ivec2> places = pack(charts, packing.density, packing.size);
    Atlas atlas;
    atlas.size = packing.size;
    atlas.charts = static_cast<int>(charts.size());
    atlas.corners.resize(scene.triangles.size());
    atlas.chart_of.resize(scene.triangles.size());
    for (size_t i = 0; i < charts.size(); ++i) {
        const glm::dvec2 scale =
            glm::dvec2(texelsOf(charts[i], packing.density)) /
            glm::max(charts[i].extent, glm::dvec2(std::numeric_limits<float>::min()));
        for (size_t k = 0; k < charts[i].triangles.size(); ++k) {
            const uint32_t triangle = charts[i].triangles[k];
            atlas.chart_of[triangle] = static_cast<uint32_t>(i);
            for (size_t c = 0; c < 3; ++c) {
                atlas.corners[triangle][c] =
                    vec2(glm::dvec2(places[i]) + scale * charts[i].corners[k][c]);
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
