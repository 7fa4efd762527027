#include "light/direct.h"

#include <algorithm>

#include "core/parallel.h"
#include "light/punctual.h"
#include "rays/surface_point.h"

namespace sheen {
namespace {

Scatterer scattererAt(const GBuffer& gbuffer, size_t i) {
    return {.n = gbuffer.mappedNormalAt(i),
            .brdf = {.diffuse = gbuffer.diffuse.pixels[i],
                     .alpha = shared::alphaFromRoughness(gbuffer.roughness.pixels[i]),
                     .f0 = gbuffer.f0.pixels[i],
                     .f90 = gbuffer.f90.pixels[i]}};
}

// Of many lights, for a sample of a pixel.
constexpr size_t kSampleParts = ManyLights::kParts / 8;

vec3 manyLights(const Tracer& tracer, const ManyLights& lights, const LitPoint& point, size_t parts,
                uint32_t seed) {
    vec3 sum(0.0f);
    vec3 light[Tracer::kPacket];
    Way ways[Tracer::kPacket];
    size_t count = 0;
    const auto flush = [&] {
        const Tracer::Shares passing = tracer.passing({ways, count});
        for (size_t k = 0; k < count; ++k) {
            sum += passing[k] != vec3(0.0f) ? passing[k] * light[k] : vec3(0.0f);
        }
        count = 0;
    };
    lights.forEachPart(point.side, point.surface.n, parts, seed, [&](const ManyLights::Sample& s) {
        light[count] = scattered(point.surface, point.side.toward_viewer, s.light);
        ways[count++] = s.way;
        if (count == Tracer::kPacket) {
            flush();
        }
    });
    flush();
    return sum;
}

// Adds what punctual lights send by way of a row's points; `seed`: of its first one.
void addPunctual(const Tracer& tracer, const ManyLights& lights, const PointAt& pointAt, int y,
                 size_t parts, uint32_t seed, Image<vec3>& direct) {
    constexpr int kPacket = Tracer::kPacket;
    int columns[kPacket];
    LitPoint points[kPacket];
    SurfaceSide sides[kPacket];
    for (int x = 0; x < direct.width;) {
        // The row's next points.
        size_t count = 0;
        for (; x < direct.width && count < kPacket; ++x) {
            if (const std::optional<LitPoint> point = pointAt(x, y)) {
                columns[count] = x;
                points[count] = *point;
                sides[count++] = point->side;
            }
        }
        for (const PunctualLight& light : lights.each()) {
            const Tracer::Shares shares = reaching(tracer, light, {sides, count});
            for (size_t k = 0; k < count; ++k) {
                if (shares[k] == vec3(0.0f)) {
                    continue;
                }
                direct.at(columns[k], y) +=
                    shares[k] * scattered(points[k].surface, sides[k].toward_viewer,
                                          shared::sampleLight(light, sides[k].position));
            }
        }
        for (size_t k = 0; k < count && !lights.empty(); ++k) {
            direct.at(columns[k], y) += manyLights(tracer, lights, points[k], parts,
                                                   seed + static_cast<uint32_t>(columns[k]));
        }
    }
}

}  // namespace

Image<vec3> traceDirect(const Tracer& tracer, const SceneLights& lights, const ivec2& size,
                        std::span<const uint32_t> rows_of, const PointAt& pointAt) {
    const size_t parts = rows_of.empty() ? ManyLights::kParts : kSampleParts;
    Image<vec3> direct(size.x, size.y);
    parallelFor(size.y, [&](int y) {
        const uint32_t row =
            rows_of.empty() ? static_cast<uint32_t>(y) : rows_of[static_cast<size_t>(y)];
        addPunctual(tracer, lights.punctual, pointAt, y, parts, row * static_cast<uint32_t>(size.x),
                    direct);
    });
    if (lights.lamps.empty()) {
        return direct;
    }
    const Image<vec3> of_lamps = lampLight(tracer, lights.lamps, size.x, size.y, rows_of, pointAt);
    for (size_t i = 0; i < direct.pixels.size(); ++i) {
        direct.pixels[i] += of_lamps.pixels[i];
    }
    return direct;
}

Image<vec3> traceDirect(const Tracer& tracer, const SceneLights& lights, const GBuffer& gbuffer,
                        std::span<const uint32_t> rows_of) {
    const PixelGrid& image = gbuffer.image;
    return traceDirect(tracer, lights, {image.width, image.height}, rows_of,
                       [&](int x, int y) -> std::optional<LitPoint> {
                           const size_t i = image.index(x, y);
                           if (!gbuffer.seen(i)) {
                               return std::nullopt;
                           }
                           return LitPoint{.side = gbuffer.sideAt(tracer.scene(), i),
                                           .surface = scattererAt(gbuffer, i)};
                       });
}

}  // namespace sheen
