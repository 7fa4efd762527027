#include "splat/upsample.h"

#include <algorithm>
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

vec3 over(const vec3& light, const vec3& albedo) {
    constexpr float kLeast = 1e-6f;
    return light / glm::max(albedo, vec3(kLeast));
}

}  // namespace

// Of records and rays, over the sources of a pixel.
struct Upsampling::Mean {
    vec3 irradiance{0.0f};
    vec3 specular{0.0f};
    vec4 missed{0.0f};
    vec3 by_rays{0.0f};   // over the albedo
    float weight = 0.0f;  // of the records: none where it is 0
};

Upsampling::Upsampling(const Receivers& coarse, const Receivers& fine)
    : coarse_(coarse), fine_(fine), sources_(fine.positions.size()) {
    SHEEN_CHECK(coarse.image.count() > 0);
    parallelFor(fine.image.height, [&](int y) {
        for (int x = 0; x < fine_.image.width; ++x) {
            const size_t i = fine_.image.index(x, y);
            if (fine_.seen(i)) {
                sources_[i] = sourcesOf(x, y);
            }
        }
    });
}

// Whether records and rays say the same things of both.
bool Upsampling::sameClass(size_t c, size_t f) const {
    return coarse_.orders[c] == fine_.orders[f] && coarse_.by_rays[c] == fine_.by_rays[f] &&
           coarse_.materials[c] == fine_.materials[f];
}

Upsampling::Sources Upsampling::sourcesOf(int x, int y) const {
    constexpr float kUnlike = 0.05f;  // less is another surface
    constexpr float kEnough = 1e-3f;
    const PixelGrid& grid = coarse_.image;
    const size_t f = fine_.image.index(x, y);
    const vec2 place = (vec2(x, y) + 0.5f) * vec2(grid.width, grid.height) /
                           vec2(fine_.image.width, fine_.image.height) -
                       0.5f;
    const ivec2 corner(glm::floor(place));
    const vec2 part = place - vec2(corner);
    Sources sources{.alike = true};
    float sum = 0.0f;
    for (int k = 0; k < 4; ++k) {
        const ivec2 at = corner + ivec2(k & 1, k >> 1);
        if (at.x < 0 || at.y < 0 || at.x >= grid.width || at.y >= grid.height) {
            continue;
        }
        const size_t c = grid.index(at.x, at.y);
        if (!coarse_.seen(c) || !sameClass(c, f)) {
            continue;
        }
        const float alike = likeness(coarse_, c, fine_, f);
        const vec2 near = 1.0f - glm::abs(part - vec2(at - corner));
        sources.all[static_cast<size_t>(k)] = {static_cast<uint32_t>(c),
                                               alike > kUnlike ? alike * near.x * near.y : 0.0f};
        sum += sources.all[static_cast<size_t>(k)].share;
    }
    if (sum <= kEnough) {
        return nearestOf(corner, f);
    }
    for (Source& source : sources.all) {
        source.share /= sum;
    }
    return sources;
}

// The one that is most like it, first of its own class, within more and more pixels.
Upsampling::Sources Upsampling::nearestOf(const ivec2& corner, size_t f) const {
    constexpr int kFarthest = 16;
    const PixelGrid& grid = coarse_.image;
    Sources sources;
    for (int around = 2; around <= kFarthest && sources.all[0].share == 0.0f; around *= 2) {
        const ivec2 first = glm::max(corner - around + 1, ivec2(0));
        const ivec2 last = glm::min(corner + around, ivec2(grid.width - 1, grid.height - 1));
        float most = -1.0f;
        for (int y = first.y; y <= last.y; ++y) {
            for (int x = first.x; x <= last.x; ++x) {
                const size_t c = grid.index(x, y);
                if (!coarse_.seen(c)) {
                    continue;
                }
                const bool same = sameClass(c, f);
                const float alike = likeness(coarse_, c, fine_, f) + (same ? 1.0f : 0.0f);
                if (alike > most) {
                    most = alike;
                    sources = {.all = {{{static_cast<uint32_t>(c), 1.0f}}}, .alike = same};
                }
            }
        }
    }
    return sources;
}

Upsampling::Mean Upsampling::meanOf(const SplatBuffer& splat, const Image<vec3>& by_rays,
                                    size_t f) const {
    Mean mean;
    float shares = 0.0f;
    for (const auto& [c, share] : sources_[f].all) {
        const vec4& sum = splat.irradiance.pixels[c];
        if (share <= 0.0f || sum.w <= shared::MIN_WEIGHT_SUM) {
            continue;
        }
        shares += share;
        mean.weight += share * sum.w;
        mean.irradiance += share / sum.w * vec3(sum);
        if (!splat.specular.empty()) {
            mean.specular += share / sum.w * vec3(splat.specular.pixels[c]);
        }
        if (!splat.missed.empty() && splat.missed.pixels[c].w > 0.0f) {
            mean.missed += share / splat.missed.pixels[c].w * splat.missed.pixels[c];
        }
        if (!by_rays.empty() && fine_.by_rays[f] != 0) {
            mean.by_rays += share * over(by_rays.pixels[c], coarse_.specularAlbedo(c));
        }
    }
    if (shares > 0.0f) {
        mean.irradiance /= shares;
        mean.specular /= shares;
        mean.by_rays /= shares;
        mean.weight /= shares;
    }
    return mean;
}

Upsampling::Light Upsampling::of(const SplatBuffer& splat, const Image<vec3>& by_rays) const {
    const int width = fine_.image.width, height = fine_.image.height;
    Light light;
    light.splat.irradiance = Image<vec4>(width, height);
    light.splat.specular = Image<vec4>(width, height);
    light.splat.missed = splat.missed.empty() ? Image<vec4>() : Image<vec4>(width, height);
    light.by_rays = fine_.anyByRays() ? Image<vec3>(width, height) : Image<vec3>();
    parallelFor(height, [&](int y) {
        for (size_t i = fine_.image.index(0, y); i < fine_.image.index(0, y + 1); ++i) {
            const Mean mean = meanOf(splat, by_rays, i);
            if (!(mean.weight > 0.0f)) {
                continue;
            }
            const bool alike = sources_[i].alike;
            // Of a lobe about which nothing is known, what it reflects of constant light.
            const vec3 radiance = mean.irradiance / kPi;
            const bool lobe = fine_.orders[i] > shared::DIFFUSE_ORDER;
            const vec3 albedo = lobe || fine_.by_rays[i] != 0 ? fine_.specularAlbedo(i) : vec3(0);
            vec3 specular = mean.specular;
            if (!alike && lobe) {
                specular = over(albedo * radiance, fine_.lobes.scale[i]);
            }
            light.splat.irradiance.pixels[i] = mean.weight * vec4(mean.irradiance, 1.0f);
            light.splat.specular.pixels[i] = mean.weight * vec4(specular, 0.0f);
            if (alike && !light.splat.missed.empty()) {
                light.splat.missed.pixels[i] = mean.missed;
            }
            if (fine_.by_rays[i] != 0) {
                light.by_rays.pixels[i] = albedo * (alike ? mean.by_rays : radiance);
            }
        }
    });
    return light;
}

Image<vec3> Upsampling::of(const Image<vec3>& light) const {
    Image<vec3> result(fine_.image.width, fine_.image.height);
    for (size_t i = 0; i < result.pixels.size(); ++i) {
        for (const Source& source : sources_[i].all) {
            if (sources_[i].alike) {
                result.pixels[i] += source.share * light.pixels[source.pixel];
            }
        }
    }
    return result;
}

}  // namespace sheen
