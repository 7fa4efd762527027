#include "receivers/lobes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

#include "core/error.h"
#include "core/parallel.h"
#include "receivers/receivers.h"
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

shared::ShVector Lobes::at(size_t i, int order) const {
    shared::ShVector lobe;
    const int16_t* from = &steps[static_cast<size_t>(first[i])];
    for (int k = 0; k < order * order; ++k) {
        lobe.c[k] = static_cast<float>(from[k]) / shared::LOBE_STEPS;
    }
    return lobe;
}

Lobes buildLobes(const Receivers& receivers) {
    Lobes lobes;
    lobes.first.assign(receivers.positions.size(), -1);
    std::map<int, BrdfRotator> rotators;
    size_t total = 0;
    for (size_t i = 0; i < lobes.first.size(); ++i) {
        const int order = receivers.orders[i];
        if (order > shared::DIFFUSE_ORDER) {
            lobes.first[i] = static_cast<int>(total);
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
        lobes.scale.resize(receivers.positions.size());
    }
    constexpr int kGrain = 64;
    parallelFor(
        receivers.count(),
        [&](int k) {
            const auto i = static_cast<size_t>(k);
            if (lobes.first[i] < 0) {
                return;
            }
            const vec3& n = receivers.scatteringNormal(i);
            const vec3 wo = receivers.towardViewer(i);
            const vec3& f0 = receivers.f0[i];
            const float f90 = receivers.f90[i];
            const float mean_f0 = (f0.x + f0.y + f0.z) / 3.0f;
            const BrdfShSample lobe = brdfSh(glm::dot(n, wo), receivers.roughness[i]);
            const int order = receivers.orders[i];
            shared::ShVector coefficients;
            rotators.at(order).rotate(lobe, mean_f0, f90, n, wo, coefficients.c);
            const float greatest = quantise(coefficients.c, order * order,
                                            &lobes.steps[static_cast<size_t>(lobes.first[i])]);
            const float albedo_a = lobe.a[0];
            const float albedo_b = lobe.b[0];
            const float mean_albedo = mean_f0 * albedo_a + f90 * albedo_b;
            lobes.scale[i] = mean_albedo > 0.0f
                                 ? greatest / mean_albedo * (f0 * albedo_a + vec3(f90 * albedo_b))
                                 : vec3(0);
        },
        kGrain);
    return lobes;
}

}  // namespace sheen
