#include "splat/upsample.h"

#include <cmath>

#include "core/error.h"
#include "core/parallel.h"

namespace sheen {
namespace {

// Of two receivers of the same view: 1 on the same plane, facing alike; falls with the distance
// from that plane, in pixels, and with the angle.
float likeness(const Receivers& coarse, size_t c, const Receivers& fine, size_t f) {
    const vec3 apart = coarse.positions[c] - fine.positions[f];
    const float off = glm::dot(apart, fine.normals[f]) / coarse.footprints[c];
    const float facing = std::max(glm::dot(coarse.normals[c], fine.normals[f]), 0.0f);
    constexpr float kSharpness = 8.0f;
    return std::pow(facing, kSharpness) * std::exp(-off * off);
}

// Whether records and rays say the same things of both.
bool sameClass(const Receivers& coarse, size_t c, const Receivers& fine, size_t f) {
    return coarse.orders[c] == fine.orders[f] && coarse.by_rays[c] == fine.by_rays[f];
}

}  // namespace

Upsampling::Upsampling(const Receivers& coarse, const Receivers& fine)
    : width_(fine.image.width), height_(fine.image.height), sources_(fine.positions.size()) {
    SHEEN_CHECK(coarse.image.count() > 0);
    parallelFor(height_, [&](int y) {
        for (int x = 0; x < width_; ++x) {
            const size_t i = fine.image.index(x, y);
            if (fine.seen(i)) {
                sources_[i] = sourcesOf(coarse, fine, x, y);
            }
        }
    });
}

Upsampling::Sources Upsampling::sourcesOf(const Receivers& coarse, const Receivers& fine, int x,
                                          int y) {
    constexpr float kUnlike = 0.05f;  // less is another surface
    constexpr int kAround = 2;        // coarse pixels in which one that is alike is looked for
    const PixelGrid& grid = coarse.image;
    const size_t f = fine.image.index(x, y);
    const vec2 place = (vec2(x, y) + 0.5f) * vec2(grid.width, grid.height) /
                           vec2(fine.image.width, fine.image.height) -
                       0.5f;
    const ivec2 corner(glm::floor(place));
    const vec2 part = place - vec2(corner);
    const auto inside = [&](int cx, int cy) {
        return cx >= 0 && cy >= 0 && cx < grid.width && cy < grid.height;
    };
    Sources sources;
    float sum = 0.0f;
    for (int k = 0; k < 4; ++k) {
        const int dx = k & 1, dy = k >> 1;
        if (!inside(corner.x + dx, corner.y + dy)) {
            continue;
        }
        const size_t c = grid.index(corner.x + dx, corner.y + dy);
        if (!coarse.seen(c) || !sameClass(coarse, c, fine, f)) {
            continue;
        }
        const float alike = likeness(coarse, c, fine, f);
        const float share =
            alike * (dx != 0 ? part.x : 1.0f - part.x) * (dy != 0 ? part.y : 1.0f - part.y);
        sources[static_cast<size_t>(k)] = {c, alike > kUnlike ? share : 0.0f};
        sum += sources[static_cast<size_t>(k)].share;
    }
    constexpr float kEnough = 1e-3f;
    if (sum > kEnough) {
        for (Source& source : sources) {
            source.share /= sum;
        }
        return sources;
    }
    sources = {};
    float most = -1.0f;
    for (int cy = corner.y - kAround + 1; cy <= corner.y + kAround; ++cy) {
        for (int cx = corner.x - kAround + 1; cx <= corner.x + kAround; ++cx) {
            if (!inside(cx, cy) || !coarse.seen(grid.index(cx, cy))) {
                continue;
            }
            const size_t c = grid.index(cx, cy);
            const float alike =
                likeness(coarse, c, fine, f) + (sameClass(coarse, c, fine, f) ? 1.0f : 0.0f);
            if (alike > most) {
                most = alike;
                sources[0] = {c, 1.0f};
            }
        }
    }
    return sources;
}

SplatBuffer Upsampling::of(const SplatBuffer& splat) const {
    SplatBuffer result;
    result.irradiance = Image<vec4>(width_, height_);
    result.specular = Image<vec4>(width_, height_);
    if (!splat.missed.empty()) {
        result.missed = Image<vec4>(width_, height_);
    }
    parallelFor(height_, [&](int y) {
        for (int x = 0; x < width_; ++x) {
            const size_t i =
                static_cast<size_t>(y) * static_cast<size_t>(width_) + static_cast<size_t>(x);
            for (const Source& source : sources_[i]) {
                const float sum = splat.irradiance.pixels[source.pixel].w;
                if (source.share <= 0.0f || sum <= shared::MIN_WEIGHT_SUM) {
                    continue;
                }
                // Means over the records, each of a weight of 1.
                const float part = source.share / sum;
                result.irradiance.pixels[i] += part * splat.irradiance.pixels[source.pixel];
                if (!splat.specular.empty()) {
                    result.specular.pixels[i] += part * splat.specular.pixels[source.pixel];
                }
                if (!splat.missed.empty() && splat.missed.pixels[source.pixel].w > 0.0f) {
                    const vec4& missed = splat.missed.pixels[source.pixel];
                    result.missed.pixels[i] += source.share / missed.w * missed;
                }
            }
        }
    });
    return result;
}

Image<vec3> Upsampling::of(const Image<vec3>& light) const {
    Image<vec3> result(width_, height_);
    for (size_t i = 0; !light.empty() && i < result.pixels.size(); ++i) {
        for (const Source& source : sources_[i]) {
            result.pixels[i] += source.share * light.pixels[source.pixel];
        }
    }
    return result;
}

}  // namespace sheen
