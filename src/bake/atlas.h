// Where in a lightmap each triangle lies: the coordinates that the file has, or charts made for it.
// Charts are pieces of surface that face about one way, unfolded onto the plane that they face, and
// packed side by side, on several pages where one is too small.
#pragma once

#include <algorithm>
#include <array>
#include <string>
#include <vector>

#include "image/image.h"
#include "scene/scene.h"

namespace sheen {

struct AtlasParams {
    /// Texels along each side of a page; 0: the least that the density asks for.
    int size = 0;
    float texels_per_metre = 0.0f;  ///< scene units; 0: as many as the size holds
};

/// Texels along a side, at the least and at the most.
constexpr int kLeastAtlas = 16;
constexpr int kLargestAtlas = 8192;
/// Texels that lie free around each chart: what is filtered takes them from its own chart.
constexpr int kPadding = 1;

struct Atlas {
    int size = 0;   ///< texels along each side of a page
    int pages = 1;  ///< one below the other: texels are `size` wide and `height()` high
    /// [triangle]: where its corners lie, in texels from the top left; texel (x, y) reaches from x
    /// to x + 1. All of a chart is on one page.
    std::vector<std::array<vec2, 3>> corners;
    std::vector<uint32_t> chart_of;  ///< [triangle]
    std::vector<int> page_of;        ///< likewise
    int charts = 0;
    bool of_file = false;  ///< the file's own coordinates; one page

    int height() const { return size * pages; }
};

/// What a page holds of an image of all texels; of an empty one, nothing.
template <class T>
Image<T> pageOf(const Atlas& atlas, const Image<T>& image, int page) {
    if (image.empty()) {
        return {};
    }
    Image<T> own(atlas.size, atlas.size);
    const auto count = static_cast<std::ptrdiff_t>(own.pixels.size());
    std::copy_n(image.pixels.begin() + page * count, count, own.pixels.begin());
    return own;
}

/// By the scene's second texture coordinates. Where they will not do, `why` says so, and the result
/// is empty: none, outside of the unit square, no area where the triangle has some, two triangles
/// over one texel's middle, more texels than the atlas may have for those asked for.
Atlas atlasOfFile(const Scene& scene, const AtlasParams& params, std::string& why);

/// By charts of its own: on one page of the size asked for, or of up to kLargestAtlas; at a density
/// asked for, on as many pages as that takes, those of a primitive on few. Usage error where they
/// do not fit: it says what would.
Atlas makeAtlas(const Scene& scene, const AtlasParams& params);

/// The first where it will do, else the second and a warning why.
Atlas atlasOf(const Scene& scene, const AtlasParams& params);

/// Of two vectors of the plane: twice the area of their triangle, below 0 where it is mirrored.
inline double cross(const glm::dvec2& a, const glm::dvec2& b) { return a.x * b.y - a.y * b.x; }

/// Twice the area that a triangle covers, in texels; below 0 where it is mirrored.
inline double doubleArea(const std::array<vec2, 3>& c) {
    return cross(glm::dvec2(c[1] - c[0]), glm::dvec2(c[2] - c[0]));
}

/// From where to where a triangle reaches within rows y to y + 1: x of its leftmost and rightmost
/// points there; the first is greater where there are none.
inline glm::dvec2 rowSpan(const std::array<vec2, 3>& c, int y) {
    glm::dvec2 span(kInfinity, -kInfinity);
    for (size_t k = 0; k < 3; ++k) {
        const glm::dvec2 a(c[k]), b(c[(k + 1) % 3]);
        const double lower = std::max(std::min(a.y, b.y), static_cast<double>(y));
        const double upper = std::min(std::max(a.y, b.y), y + 1.0);
        if (lower > upper) {
            continue;
        }
        for (const double at : {lower, upper}) {
            const double along = a.y == b.y ? 0.0 : glm::clamp((at - a.y) / (b.y - a.y), 0.0, 1.0);
            const double x = a.x + along * (b.x - a.x);
            span = {std::min(span.x, x), std::max(span.y, x)};
        }
    }
    return span;
}

}  // namespace sheen
