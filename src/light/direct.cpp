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

}  // namespace

Image<vec3> traceDirect(const Tracer& tracer, const LampSampler& lamps, const GBuffer& gbuffer,
                        std::span<const uint32_t> rows_of) {
    constexpr int kPacket = Tracer::kPacket;
    const Scene& scene = tracer.scene();
    const PixelGrid& image = gbuffer.image;
    Image<vec3> direct(image.width, image.height);
    parallelFor(image.height, [&](int y) {
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
                points[count++] = gbuffer.sideAt(scene, i);
            }
            for (const PunctualLight& light : scene.lights) {
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
        }
    });
    if (lamps.empty()) {
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
        lampLight(tracer, lamps, image.width, image.height, rows_of, pointAt);
    for (size_t i = 0; i < direct.pixels.size(); ++i) {
        direct.pixels[i] += of_lamps.pixels[i];
    }
    return direct;
}

}  // namespace sheen
