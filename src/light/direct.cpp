#include "light/direct.h"

#include <algorithm>

#include "core/parallel.h"
#include "light/lamp_light.h"
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
            sum += passing[k] > 0.0f ? passing[k] * light[k] : vec3(0.0f);
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

// Adds what punctual lights send by way of a row's pixels; `seed`: of its first one.
void addPunctual(const Tracer& tracer, const ManyLights& lights, const GBuffer& gbuffer, int y,
                 size_t parts, uint32_t seed, Image<vec3>& direct) {
    constexpr int kPacket = Tracer::kPacket;
    const PixelGrid& image = gbuffer.image;
    size_t pixels[kPacket];
    SurfaceSide points[kPacket];
    for (int x = 0; x < image.width;) {
        // The row's next pixels that see something.
        size_t count = 0;
        for (; x < image.width && count < kPacket; ++x) {
            const size_t i = image.index(x, y);
            if (!gbuffer.seen(i)) {
                continue;
            }
            pixels[count] = i;
            points[count++] = gbuffer.sideAt(tracer.scene(), i);
        }
        for (const PunctualLight& light : lights.each()) {
            const Tracer::Shares shares = reaching(tracer, light, {points, count});
            for (size_t k = 0; k < count; ++k) {
                if (shares[k] == 0.0f) {
                    continue;
                }
                const size_t i = pixels[k];
                direct.pixels[i] +=
                    shares[k] * scattered(scattererAt(gbuffer, i), points[k].toward_viewer,
                                          shared::sampleLight(light, points[k].position));
            }
        }
        for (size_t k = 0; k < count && !lights.empty(); ++k) {
            const size_t i = pixels[k];
            const LitPoint point{.side = points[k], .surface = scattererAt(gbuffer, i)};
            direct.pixels[i] += manyLights(tracer, lights, point, parts,
                                           seed + static_cast<uint32_t>(i - image.index(0, y)));
        }
    }
}

}  // namespace

Image<vec3> traceDirect(const Tracer& tracer, const SceneLights& lights, const GBuffer& gbuffer,
                        std::span<const uint32_t> rows_of) {
    const Scene& scene = tracer.scene();
    const PixelGrid& image = gbuffer.image;
    const size_t parts = rows_of.empty() ? ManyLights::kParts : kSampleParts;
    Image<vec3> direct(image.width, image.height);
    parallelFor(image.height, [&](int y) {
        const uint32_t row =
            rows_of.empty() ? static_cast<uint32_t>(y) : rows_of[static_cast<size_t>(y)];
        addPunctual(tracer, lights.punctual, gbuffer, y, parts,
                    row * static_cast<uint32_t>(image.width), direct);
    });
    if (lights.lamps.empty()) {
        return direct;
    }
    const auto pointAt = [&](int x, int y) -> std::optional<LitPoint> {
        const size_t i = image.index(x, y);
        if (!gbuffer.seen(i)) {
            return std::nullopt;
        }
        return LitPoint{.side = gbuffer.sideAt(scene, i), .surface = scattererAt(gbuffer, i)};
    };
    const Image<vec3> of_lamps =
        lampLight(tracer, lights.lamps, image.width, image.height, rows_of, pointAt);
    for (size_t i = 0; i < direct.pixels.size(); ++i) {
        direct.pixels[i] += of_lamps.pixels[i];
    }
    return direct;
}

}  // namespace sheen
