#include "cache/direct_rays.h"

#include <algorithm>

#include "core/parallel.h"
#include "rays/surface_point.h"

namespace sheen {

Image<vec3> traceDirect(const RayCaster& rays, const GBuffer& gbuffer) {
    constexpr int kPacket = RayCaster::kPacket;
    const Scene& scene = rays.scene();
    const PixelGrid& image = gbuffer.image;
    Image<vec3> direct(image.width, image.height);
    parallelFor(image.height, [&](int y) {
        size_t pixels[kPacket];
        RayCaster::Receiver receivers[kPacket];
        for (int x = 0; x < image.width;) {
            // The row's next pixels that see something.
            size_t count = 0;
            for (; x < image.width && count < kPacket; ++x) {
                const size_t i = image.index(x, y);
                if (!gbuffer.seen(static_cast<int>(i))) {
                    continue;
                }
                pixels[count] = i;
                receivers[count++] = receiverAt(scene, gbuffer.primitive.pixels[i],
                                                gbuffer.position.pixels[i], image.view.origin);
            }
            for (const PunctualLight& light : scene.lights) {
                const uint32_t lit = rays.reached(light, {receivers, count});
                for (size_t k = 0; k < count; ++k) {
                    if ((lit >> k & 1u) == 0) {
                        continue;
                    }
                    const size_t i = pixels[k];
                    const float roughness = gbuffer.roughness.pixels[i];
                    const Scatterer surface{.n = gbuffer.normal.pixels[i],
                                            .brdf = {.diffuse = gbuffer.diffuse.pixels[i],
                                                     .alpha = shared::alphaFromRoughness(roughness),
                                                     .f0 = gbuffer.f0.pixels[i],
                                                     .f90 = gbuffer.f90.pixels[i]}};
                    direct.pixels[i] +=
                        scattered(surface, receivers[k].toward_viewer,
                                  shared::sampleLight(light, receivers[k].position));
                }
            }
        }
    });
    return direct;
}

}  // namespace sheen
