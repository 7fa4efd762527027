#include "light/direct.h"

#include <algorithm>

#include "core/parallel.h"
#include "light/punctual.h"
#include "rays/surface_point.h"

namespace sheen {

Image<vec3> traceDirect(const Tracer& tracer, const GBuffer& gbuffer) {
    constexpr int kPacket = Tracer::kPacket;
    const Scene& scene = tracer.scene();
    Image<vec3> direct(gbuffer.width, gbuffer.height);
    parallelFor(gbuffer.height, [&](int y) {
        size_t pixels[kPacket];
        SurfaceSide points[kPacket];
        for (int x = 0; x < gbuffer.width;) {
            // The row's next pixels that see something.
            size_t count = 0;
            for (; x < gbuffer.width && count < kPacket; ++x) {
                const int i = y * gbuffer.width + x;
                if (!gbuffer.seen(i)) {
                    continue;
                }
                pixels[count] = static_cast<size_t>(i);
                points[count++] = gbuffer.sideAt(scene, i);
            }
            for (const PunctualLight& light : scene.lights) {
                const uint32_t lit = reached(tracer, light, {points, count});
                for (size_t k = 0; k < count; ++k) {
                    if ((lit >> k & 1u) == 0) {
                        continue;
                    }
                    const size_t i = pixels[k];
                    const vec4& normal = gbuffer.normal.pixels[i];
                    const vec4& diffuse = gbuffer.diffuse.pixels[i];
                    const Scatterer surface{.n = gbuffer.mappedNormalAt(i),
                                            .brdf = {.diffuse = vec3(diffuse),
                                                     .alpha = shared::alphaFromRoughness(normal.w),
                                                     .f0 = gbuffer.f0.pixels[i],
                                                     .f90 = diffuse.w}};
                    direct.pixels[i] += scattered(surface, points[k].toward_viewer,
                                                  shared::sampleLight(light, points[k].position));
                }
            }
        }
    });
    return direct;
}

}  // namespace sheen
