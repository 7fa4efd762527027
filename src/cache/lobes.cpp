#include "cache/lobes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "cache/record.h"
#include "core/error.h"
#include "core/parallel.h"
#include "scene/brdf_albedo.h"
#include "sh/brdf_sh.h"

namespace sheen {
namespace {

// Writes coefficients as steps and returns the greatest one's magnitude; not a number where one is
// not, which compose() counts.
float quantise(const float* coefficients, int count, int16_t* steps) {
    float greatest = 0.0f;
    for (int i = 0; i < count; ++i) {
        if (!std::isfinite(coefficients[i])) {
            std::fill(steps, steps + count, int16_t{0});
            return std::numeric_limits<float>::quiet_NaN();
        }
        greatest = std::max(greatest, std::abs(coefficients[i]));
    }
    const float scale = greatest > 0.0f ? shared::LOBE_STEPS / greatest : 0.0f;
    for (int i = 0; i < count; ++i) {
        const float step = scale * coefficients[i];
        steps[i] = static_cast<int16_t>(step + (step < 0.0f ? -0.5f : 0.5f));
    }
    return greatest;
}

}  // namespace

shared::ShVector PixelLobes::at(int pixel, int order) const {
    shared::ShVector lobe;
    const int16_t* from = &steps[static_cast<size_t>(first.pixels[static_cast<size_t>(pixel)])];
    for (int i = 0; i < order * order; ++i) {
        lobe.c[i] = static_cast<float>(from[i]) / shared::LOBE_STEPS;
    }
    return lobe;
}

vec3 specularAlbedo(const GBuffer& gbuffer, int pixel) {
    const auto i = static_cast<size_t>(pixel);
    const vec4& normal = gbuffer.normal.pixels[i];
    const vec3 wo = glm::normalize(gbuffer.view.origin - vec3(gbuffer.position.pixels[i]));
    const vec2 ab = brdfAlbedo(glm::dot(vec3(normal), wo), normal.w);
    return gbuffer.f0.pixels[i] * ab.x + vec3(gbuffer.diffuse.pixels[i].w * ab.y);
}

PixelLobes buildLobes(const GBuffer& gbuffer, const PixelClasses& classes) {
    PixelLobes lobes;
    lobes.first = Image<int>(gbuffer.width, gbuffer.height, -1);
    std::map<int, BrdfRotator> rotators;
    size_t total = 0;
    for (int i = 0; i < gbuffer.width * gbuffer.height; ++i) {
        const int order = classes.orders.pixels[static_cast<size_t>(i)];
        if (order > shared::DIFFUSE_ORDER) {
            lobes.first.pixels[static_cast<size_t>(i)] = static_cast<int>(total);
            total += static_cast<size_t>(shared::lobeGroupFirst(shared::lobeGroups(order)));
            rotators.try_emplace(order, order);
        }
    }
    if (total > static_cast<size_t>(std::numeric_limits<int>::max())) {
        throwEnvironment("the lobes of glossy pixels have {} coefficients; render a smaller image",
                         total);
    }
    lobes.steps.resize(total);
    if (total > 0) {
        lobes.scale = Image<vec3>(gbuffer.width, gbuffer.height);
    }
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
            const vec3 f0 = gbuffer.f0.at(x, y);
            const float f90 = gbuffer.diffuse.at(x, y).w;
            const float mean_f0 = (f0.x + f0.y + f0.z) / 3.0f;
            const BrdfShSample lobe = brdfSh(NoV, normal.w);
            const int order = classes.orders.at(x, y);
            shared::ShVector coefficients;
            rotators.at(order).rotate(lobe, mean_f0, f90, n, wo, coefficients.c);
            const float greatest =
                quantise(coefficients.c, order * order, &lobes.steps[static_cast<size_t>(first)]);
            const float albedo_a = lobe.a[0];
            const float albedo_b = lobe.b[0];
            const float mean_albedo = mean_f0 * albedo_a + f90 * albedo_b;
            lobes.scale.at(x, y) =
                mean_albedo > 0.0f ? greatest / mean_albedo * (f0 * albedo_a + vec3(f90 * albedo_b))
                                   : vec3(0);
        }
    });
    return lobes;
}

}  // namespace sheen
