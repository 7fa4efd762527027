#include "core/parallel.h"
#include "splat/splat.h"

namespace sheen {
namespace {

// The lobe's convolution with a record's coefficients extrapolated to p.
vec3 convolve(const Record& k, const float* sh, const float* lobe, int order, const vec3& p) {
    const ShLayout layout = shLayout(k.order);
    const vec3 d = p - k.position;
    const float along[2] = {glm::dot(d, k.tangent), glm::dot(d, glm::cross(k.normal, k.tangent))};
    vec3 sum(0.0f);
    for (int i = 0; i < order * order; ++i) {
        for (int c = 0; c < 3; ++c) {
            float value = sh[c * layout.coefficients() + i];
            for (int axis = 0; axis < 2 && i < layout.gradientCoefficients(); ++axis) {
                value += along[axis] *
                         sh[layout.gradientFirst(axis) + c * layout.gradientCoefficients() + i];
            }
            sum[c] += lobe[i] * value;
        }
    }
    return sum;
}

}  // namespace

SplatBuffer splatCpu(const GBuffer& gbuffer, const PixelClasses& classes, const PixelLobes& lobes,
                     const RecordCache& cache, const WeightParams& weight) {
    SplatBuffer result{Image<vec4>(gbuffer.width, gbuffer.height),
                       Image<vec4>(gbuffer.width, gbuffer.height)};
    parallelFor(gbuffer.height, [&](int y) {
        for (int x = 0; x < gbuffer.width; ++x) {
            const int order = classes.orders.at(x, y);
            const vec4 position = gbuffer.position.at(x, y);
            const vec3 p(position);
            const vec3 n(gbuffer.normal.at(x, y));
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
                if (order > shared::DIFFUSE_ORDER) {
                    const float* lobe =
                        &lobes.coefficients[static_cast<size_t>(lobes.first.at(x, y))];
                    const float* sh = &cache.sh[static_cast<size_t>(k.sh_first)];
                    result.specular.at(x, y) += vec4(w * convolve(k, sh, lobe, order, p), 0.0f);
                }
            }
        }
    });
    return result;
}

}  // namespace sheen
