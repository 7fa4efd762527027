#include "bake/dilate.h"

#include <algorithm>

#include "image/frame.h"

namespace sheen {
namespace {

// Fills texels that wanted(i), ring by ring from those that are known, each by the mean of those
// around it that were known before and that may(from, to).
template <class Wanted, class May>
void grow(Image<vec3>& light, std::vector<uint8_t>& known, const Wanted& wanted, const May& may) {
    const int width = light.width, height = light.height;
    const auto forAround = [&](size_t i, const auto& body) {
        const auto x = static_cast<int>(i % static_cast<size_t>(width));
        const auto y = static_cast<int>(i / static_cast<size_t>(width));
        for (int v = std::max(y - 1, 0); v <= std::min(y + 1, height - 1); ++v) {
            for (int u = std::max(x - 1, 0); u <= std::min(x + 1, width - 1); ++u) {
                body(static_cast<size_t>(v) * static_cast<size_t>(width) + static_cast<size_t>(u));
            }
        }
    };
    std::vector<uint8_t> queued(known.size());
    const auto ringAround = [&](const std::vector<size_t>& texels) {
        std::vector<size_t> ring;
        for (const size_t i : texels) {
            forAround(i, [&](size_t j) {
                if (known[j] == 0 && queued[j] == 0 && wanted(j) && may(i, j)) {
                    queued[j] = 1;
                    ring.push_back(j);
                }
            });
        }
        return ring;
    };
    std::vector<size_t> all;
    for (size_t i = 0; i < known.size(); ++i) {
        if (known[i] != 0) {
            all.push_back(i);
        }
    }
    for (std::vector<size_t> ring = ringAround(all); !ring.empty(); ring = ringAround(ring)) {
        for (const size_t i : ring) {
            vec3 sum(0.0f);
            float count = 0.0f;
            forAround(i, [&](size_t j) {
                if (known[j] != 0 && may(j, i)) {
                    sum += light.pixels[j];
                    count += 1.0f;
                }
            });
            light.pixels[i] = sum / count;
        }
        for (const size_t i : ring) {
            known[i] = 1;
        }
    }
}

}  // namespace

void dilate(const Lightmap& map, Image<vec3>& light) {
    const std::vector<uint32_t>& triangles = map.triangles.pixels;
    std::vector<uint8_t> known(light.pixels.size());
    for (size_t i = 0; i < known.size(); ++i) {
        known[i] = map.receivers.seen(i) ? 1 : 0;
    }
    const auto chart = [&](size_t i) { return map.atlas.chart_of[triangles[i]]; };
    grow(
        light, known, [&](size_t i) { return triangles[i] != kNoPrimitive; },
        [&](size_t from, size_t to) { return chart(from) == chart(to); });
    grow(
        light, known, [](size_t) { return true; }, [](size_t, size_t) { return true; });
}

}  // namespace sheen
