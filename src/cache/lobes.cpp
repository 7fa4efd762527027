#include "cache/lobes.h"

#include <map>

#include "cache/record.h"
#include "core/parallel.h"
#include "sh/brdf_sh.h"

namespace sheen {

PixelLobes buildLobes(const GBuffer& gbuffer, const PixelClasses& classes) {
    PixelLobes lobes;
    lobes.first = Image<int>(gbuffer.width, gbuffer.height, -1);
    lobes.scale = Image<vec3>(gbuffer.width, gbuffer.height);
    std::map<int, BrdfRotator> rotators;
    int total = 0;
    for (int i = 0; i < gbuffer.width * gbuffer.height; ++i) {
        const int order = classes.orders.pixels[static_cast<size_t>(i)];
        if (order > shared::DIFFUSE_ORDER) {
            lobes.first.pixels[static_cast<size_t>(i)] = total;
            total += order * order;
            rotators.try_emplace(order, order);
        }
    }
    lobes.coefficients.resize(static_cast<size_t>(total));
    parallelFor(gbuffer.height, [&](int y) {
        for (int x = 0; x < gbuffer.width; ++x) {
            const int first = lobes.first.at(x, y);
            if (first < 0) {
                continue;
            }
            const vec4 normal = gbuffer.normal.at(x, y);
            const vec3 n(normal);
            const vec3 wo = glm::normalize(gbuffer.view.origin - vec3(gbuffer.position.at(x, y)));
            const float NoV = glm::dot(n, wo);
            const vec3 f0(gbuffer.f0.at(x, y));
            const float f90 = gbuffer.diffuse.at(x, y).w;
            const float mean_f0 = (f0.x + f0.y + f0.z) / 3.0f;
            const BrdfShSample lobe = brdfSh(NoV, normal.w);
            rotators.at(classes.orders.at(x, y))
                .rotate(lobe, mean_f0, f90, n, wo, &lobes.coefficients[static_cast<size_t>(first)]);
            const float albedo_a = lobe.a[0];
            const float albedo_b = lobe.b[0];
            const float mean_albedo = mean_f0 * albedo_a + f90 * albedo_b;
            lobes.scale.at(x, y) =
                mean_albedo > 0.0f ? (f0 * albedo_a + vec3(f90 * albedo_b)) / mean_albedo : vec3(0);
        }
    });
    return lobes;
}

}  // namespace sheen
