#include "bake/seams.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "image/frame.h"

namespace sheen {
namespace {

// Of normals on a smooth surface.
constexpr float kSmooth = 0.95f;
// Neighbours lie no farther off, in footprints.
constexpr float kNear = 1.5f;
// And, within a chart, no farther off in the atlas than so many texels.
constexpr int kTogether = 3;

struct Square {
    double sum = 0.0;
    int64_t count = 0;

    void add(double value) {
        sum += value * value;
        ++count;
    }
    double root() const { return count > 0 ? std::sqrt(sum / static_cast<double>(count)) : 0.0; }
};

}  // namespace

Seams seamsOf(const Lightmap& map, const Image<vec3>& light) {
    const Receivers& r = map.receivers;
    const auto chart = [&](size_t i) { return map.atlas.chart_of[r.triangles[i]]; };
    // Of two charts, or of one that closes in space, as that of a column does.
    const auto parted = [&](size_t i, size_t j) {
        const auto width = static_cast<size_t>(r.image.width);
        const ivec2 way(static_cast<int>(i % width) - static_cast<int>(j % width),
                        static_cast<int>(i / width) - static_cast<int>(j / width));
        return chart(i) != chart(j) || std::max(std::abs(way.x), std::abs(way.y)) > kTogether;
    };
    // Points that lie closer than a texel's width count as if so far off.
    const auto change = [&](size_t i, size_t j) {
        const float way = glm::length(r.positions[i] - r.positions[j]) / r.footprints[i];
        return std::abs(luminance(light.pixels[i]) - luminance(light.pixels[j])) /
               std::max(way, 1.0f);
    };
    Square across, within;
    for (int y = 0; y < light.height; ++y) {
        for (int x = 0; x < light.width; ++x) {
            const size_t i = r.image.index(x, y);
            if (!r.seen(i)) {
                continue;
            }
            std::optional<size_t> other;
            float least = kInfinity;
            for (const uint32_t j : r.places->within(r.positions[i], kNear * r.footprints[i])) {
                const float way = glm::length(r.positions[i] - r.positions[j]);
                if (parted(i, j) && glm::dot(r.normals[i], r.normals[j]) > kSmooth &&
                    (way < least || (way == least && other && j < *other))) {
                    least = way;
                    other = j;
                }
            }
            if (!other) {
                continue;
            }
            across.add(change(i, *other));
            for (const ivec2 step : {ivec2(1, 0), ivec2(-1, 0), ivec2(0, 1), ivec2(0, -1)}) {
                const ivec2 at = ivec2(x, y) + step;
                if (at.x < 0 || at.y < 0 || at.x >= light.width || at.y >= light.height) {
                    continue;
                }
                const size_t j = r.image.index(at.x, at.y);
                if (r.seen(j) && chart(j) == chart(i)) {
                    within.add(change(i, j));
                }
            }
        }
    }
    return {
        .texels = static_cast<int>(across.count), .across = across.root(), .within = within.root()};
}

}  // namespace sheen
