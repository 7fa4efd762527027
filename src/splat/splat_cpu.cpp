#include "cache/served.h"
#include "core/parallel.h"
#include "splat/splat.h"

namespace sheen {
SplatBuffer splatCpu(const GBuffer& gbuffer, const PixelClasses& classes, const PixelLobes& lobes,
                     const RecordCache& cache, const WeightParams& weight) {
    SplatBuffer result{Image<vec4>(gbuffer.width, gbuffer.height),
                       Image<vec4>(gbuffer.width, gbuffer.height),
                       Image<vec4>(gbuffer.width, gbuffer.height)};
    parallelFor(gbuffer.height, [&](int y) {
        for (int x = 0; x < gbuffer.width; ++x) {
            const int order = classes.orders.at(x, y);
            const vec4 position = gbuffer.position.at(x, y);
            const vec3 p(position);
            const vec3 n(gbuffer.normal.at(x, y));
            const shared::ShVector lobe = order > shared::DIFFUSE_ORDER
                                              ? lobes.at(y * gbuffer.width + x, order)
                                              : shared::ShVector{};
            for (const Record& k : cache.records) {
                if (!serves(k.order, order)) {
                    continue;
                }
                const float w = shared::recordWeight(weight, k.position, k.normal, k.radius, p, n,
                                                     position.w * gbuffer.pixel_angle);
                if (w <= 0.0f) {
                    continue;
                }
                result.irradiance.at(x, y) += vec4(w * shared::recordIrradiance(k, p, n), w);
                if (static_cast<int>(k.material) == classes.materials.at(x, y)) {
                    result.missed.at(x, y) += vec4(w * shared::recordMissed(k), w);
                }
                if (order > shared::DIFFUSE_ORDER) {
                    const float* sh = &cache.sh[static_cast<size_t>(k.sh_first)];
                    result.specular.at(x, y) +=
                        vec4(w * convolveRecord(k, sh, lobe.c, order, p), 0.0f);
                }
            }
        }
    });
    return result;
}

Image<float> countRecords(const GBuffer& gbuffer, const PixelClasses& classes,
                          const RecordCache& cache, const WeightParams& weight) {
    Image<float> counts(gbuffer.width, gbuffer.height);
    for (const Record& k : cache.records) {
        forServed(gbuffer, classes, k, weight,
                  [&](size_t pixel, float) { counts.pixels[pixel] += 1.0f; });
    }
    return counts;
}

}  // namespace sheen
