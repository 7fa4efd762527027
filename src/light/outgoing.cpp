#include "light/outgoing.h"

#include <algorithm>

namespace sheen {

void OutgoingLight::cast(const Rays& rays, vec4* seen, vec3* planes, Hit* met) const {
    Hit hits[kTogether];
    vec3 light[kTogether];
    for (size_t first = 0; first < rays.directions.size(); first += kTogether) {
        const size_t count = std::min(kTogether, rays.directions.size() - first);
        const Rays part = rays.part(first, count);
        tracer_.meet(part, hits, planes != nullptr ? planes + first : nullptr);
        radiance(part, {hits, count}, light);
        for (size_t i = 0; i < count; ++i) {
            seen[first + i] = vec4(light[i], hits[i].found() ? hits[i].distance : 0.0f);
        }
        if (met != nullptr) {
            std::copy_n(hits, count, met + first);
        }
    }
}

}  // namespace sheen
