#include "receivers/predicted.h"

#include "receivers/served.h"

namespace sheen {

float outgoingLuminance(const Receivers& receivers, const Record& record, const float* sh,
                        size_t i) {
    const vec3 irradiance = irradianceBy(receivers, i, record);
    if (receivers.irradiance_only || receivers.isTooGlossy(i)) {
        return luminance(irradiance);
    }
    const vec3 albedo = receivers.specularAlbedo(i);
    if (albedo == vec3(0.0f)) {
        return luminance(irradiance);
    }
    vec3 light = lobeLight(receivers, record, sh, i);
    if (static_cast<int>(record.material) == receivers.materials[i]) {
        light += shared::recordMissed(record);
    }
    return luminance(receivers.diffuse[i] * irradiance / kPi +
                     albedo * glm::max(light, vec3(0.0f)));
}

vec3 lobeLight(const Receivers& receivers, const Record& record, const float* sh, size_t i) {
    const vec3& p = receivers.positions[i];
    const int order = receivers.orders[i];
    if (order == shared::DIFFUSE_ORDER) {
        return irradianceBy(receivers, i, record) / kPi;
    }
    const shared::ShVector lobe = receivers.lobes.at(i, order);
    return receivers.lobes.scale[i] * convolveRecord(record, sh, lobe.c, order, p) /
           glm::max(receivers.specularAlbedo(i), vec3(1e-12f));
}

}  // namespace sheen
