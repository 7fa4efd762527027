#include "light/direct.h"

#include <algorithm>

#include "core/parallel.h"
#include "light/punctual.h"
#include "rays/surface_point.h"

namespace sheen {

Image<vec3> traceDirect(const Tracer& tracer, const GBuffer& gbuffer) {
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
                const uint32_t lit = reached(tracer, light, {points, count});
                for (size_t k = 0; k < count; ++k) {
                    if ((lit >> k & 1u) == 0) {
                        continue;
                    }
                    const size_t i = pixels[k];
                    const float roughness = gbuffer.roughness.pixels[i];
                    const Scatterer surface{.n = gbuffer.mappedNormalAt(i),
                                            .brdf = {.diffuse = gbuffer.diffuse.pixels[i],
                                                     .alpha = shared::alphaFromRoughness(roughness),
                                                     .f0 = gbuffer.f0.pixels[i],
                                                     .f90 = gbuffer.f90.pixels[i]}};
                    direct.pixels[i] += scattered(surface, points[k].toward_viewer,
                                                  shared::sampleLight(light, points[k].position));
                }
            }
        }
    });
    return direct;
}

}  // namespace sheen
