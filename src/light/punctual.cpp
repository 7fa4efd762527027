#include "light/punctual.h"

#include <algorithm>

#include "core/error.h"

namespace sheen {
namespace {

// A shadow ray ends this fraction short of its light, so that a light lying on a surface is not
// hidden by it.
constexpr float kShadowRayShare = 1.0f - 1e-5f;

}  // namespace

Way wayTo(const PunctualLight& light, const LightSample& sample, const vec3& start) {
    if (sample.distance < 0.0f) {
        return {.start = start, .direction = sample.wi, .length = kInfinity};
    }
    const vec3 to_light = light.position - start;
    const float distance = std::max(glm::length(to_light), 1e-30f);
    return {.start = start, .direction = to_light / distance, .length = distance * kShadowRayShare};
}

Tracer::Shares reaching(const Tracer& tracer, const PunctualLight& light,
                        std::span<const SurfaceSide> points) {
    SHEEN_CHECK(points.size() <= Tracer::kPacket);
    Way ways[Tracer::kPacket];
    for (size_t k = 0; k < points.size(); ++k) {
        const SurfaceSide& p = points[k];
        const LightSample sample = shared::sampleLight(light, p.position);
        if (glm::dot(p.n_g, sample.wi) > 0.0f && sample.irradiance != vec3(0.0f)) {
            ways[k] = wayTo(light, sample, p.start());
        }
    }
    return tracer.passing({ways, points.size()});
}

}  // namespace sheen
