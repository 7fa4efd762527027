#include "render/pixel_parts.h"

#include <algorithm>
#include <cmath>

#include "raster/gbuffer.h"
#include "receivers/served.h"
#include "sh/sh.h"

namespace sheen {
namespace {

constexpr int kDisc = 64;  // pixels across

// World-space directions of a disc's pixels; zero outside.
std::vector<vec3> discDirections(const vec3& normal) {
    const mat3 frame = tangentFrame(normal);
    std::vector<vec3> directions(static_cast<size_t>(kDisc) * kDisc);
    for (int y = 0; y < kDisc; ++y) {
        for (int x = 0; x < kDisc; ++x) {
            const vec2 p = (2.0f * vec2(x, y) + 1.0f) / static_cast<float>(kDisc) - 1.0f;
            const float r2 = glm::dot(p, p);
            if (r2 < 1.0f) {
                const vec2 around = p * std::sqrt(2.0f - r2);
                directions[static_cast<size_t>(y * kDisc + x)] =
                    frame * vec3(around.x, -around.y, 1.0f - r2);
            }
        }
    }
    return directions;
}

Image<vec3> lookAround(const OutgoingLight& light, const vec3& eye,
                       std::span<const vec3> directions) {
    std::vector<vec3> cast;
    std::vector<size_t> of;
    for (size_t i = 0; i < directions.size(); ++i) {
        if (directions[i] != vec3(0.0f)) {
            cast.push_back(directions[i]);
            of.push_back(i);
        }
    }
    std::vector<vec4> seen(cast.size());
    light.cast({.origin = eye, .directions = cast}, seen.data());
    Image<vec3> disc(kDisc, kDisc);
    for (size_t i = 0; i < of.size(); ++i) {
        disc.pixels[of[i]] = vec3(seen[i]);
    }
    return disc;
}

Image<vec3> reconstruct(const Record& record, const float* sh, std::span<const vec3> directions) {
    const int count = shLayout(record.order).coefficients();
    Image<vec3> disc(kDisc, kDisc);
    for (size_t i = 0; i < directions.size(); ++i) {
        if (directions[i] == vec3(0.0f)) {
            continue;
        }
        const shared::ShVector basis = shared::shBasis(directions[i], record.order);
        for (int channel = 0; channel < 3; ++channel) {
            const float* own = sh + channel * count;
            for (int c = 0; c < count; ++c) {
                disc.pixels[i][channel] += own[c] * basis.c[c];
            }
        }
    }
    return disc;
}

}  // namespace

PixelParts partsOf(const SceneState& state, const RenderParams& params, const ivec2& pixel,
                   int order, const RecordCache& cache, const WeightParams& weight) {
    RenderParams one = params;
    one.width = one.height = 1;
    one.window = {.first = pixel, .whole = {params.width, params.height}};
    const Receivers receivers =
        fieldsOf(renderGBuffer(state.tracer, viewOf(state.scene, one), 1, 1));
    PixelParts parts;
    parts.pixel = pixel;
    parts.seen = receivers.seen(0);
    parts.order = order;
    if (!parts.seen) {
        return parts;
    }
    parts.position = receivers.positions[0];
    parts.normal = receivers.normals[0];
    parts.roughness = receivers.roughness[0];
    float sum = 0.0f;
    for (size_t k = 0; k < cache.records.size(); ++k) {
        const Record& record = cache.records[k];
        const float w = weightAt(receivers, 0, record, weight);
        if (serves(record.order, order) && w > 0.0f) {
            parts.records.push_back({k, w, glm::distance(record.position, parts.position),
                                     weight.accuracy * record.radius});
            sum += w;
        }
    }
    for (PixelParts::Serving& serving : parts.records) {
        serving.share /= sum;
    }
    std::stable_sort(parts.records.begin(), parts.records.end(),
                     [](const auto& a, const auto& b) { return a.share > b.share; });
    if (parts.records.empty()) {
        return parts;
    }
    const Record& heaviest = cache.records[parts.records.front().record];
    SurfaceSide side = receivers.sideAt(state.scene, 0);
    side.position = heaviest.position;
    const std::vector<vec3> directions = discDirections(heaviest.normal);
    const OutgoingLight& light = params.bounces > 1 && state.again
                                     ? static_cast<const OutgoingLight&>(*state.again)
                                     : *state.outgoing;
    parts.hemisphere = lookAround(light, side.start(), directions);
    if (heaviest.order != shared::DIFFUSE_ORDER) {
        parts.reconstruction =
            reconstruct(heaviest, cache.sh.data() + heaviest.sh_first, directions);
    }
    return parts;
}

}  // namespace sheen
