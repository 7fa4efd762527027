#include "receivers/receivers.h"

#include <algorithm>
#include <utility>

#include "rays/jitter.h"
#include "receivers/classes.h"
#include "scene/brdf_albedo.h"

namespace sheen {

vec3 Receivers::specularAlbedo(size_t i) const {
    return sheen::specularAlbedo(glm::dot(scatteringNormal(i), towardViewer(i)), roughness[i],
                                 f0[i], f90[i]);
}

Receivers fieldsOf(GBuffer gbuffer) {
    Receivers receivers;
    receivers.image = gbuffer.image;
    receivers.positions = std::move(gbuffer.position.pixels);
    receivers.normals = std::move(gbuffer.normal.pixels);
    receivers.mapped_normals = std::move(gbuffer.mapped_normal.pixels);
    receivers.footprints = std::move(gbuffer.depth.pixels);
    for (float& width : receivers.footprints) {
        width *= gbuffer.image.pixel_angle;
    }
    receivers.triangles = std::move(gbuffer.primitive.pixels);
    receivers.diffuse = std::move(gbuffer.diffuse.pixels);
    receivers.f0 = std::move(gbuffer.f0.pixels);
    receivers.f90 = std::move(gbuffer.f90.pixels);
    receivers.roughness = std::move(gbuffer.roughness.pixels);
    receivers.direct = std::move(gbuffer.direct.pixels);
    receivers.emission = std::move(gbuffer.emission.pixels);
    receivers.eyes = std::move(gbuffer.eye.pixels);
    std::vector<uint32_t> bent;
    for (size_t i = 0; i < receivers.eyes.size(); ++i) {
        if (receivers.isBent(i)) {
            bent.push_back(static_cast<uint32_t>(i));
        }
    }
    if (bent.empty()) {
        receivers.eyes.clear();
    } else {
        receivers.places = std::make_shared<PointIndex>(receivers.positions, std::move(bent));
    }
    return receivers;
}

Receivers receiversOf(const Scene& scene, GBuffer gbuffer, int sh_order, bool irradiance_only) {
    Receivers receivers = fieldsOf(std::move(gbuffer));
    classify(scene, sh_order, irradiance_only, receivers);
    receivers.lobes = buildLobes(receivers);
    return receivers;
}

std::vector<ElementSite> someOf(const Scene& scene, const Receivers& receivers) {
    constexpr double kSome = 1024.0;
    const double share = kSome / std::max(receivers.counts.seen, 1);
    std::vector<ElementSite> some;
    for (size_t i = 0; i < receivers.positions.size(); ++i) {
        if (receivers.seen(i) && pcgHash(static_cast<uint32_t>(i)) * 0x1p-32 < share) {
            some.push_back({.side = receivers.sideAt(scene, i), .normal = receivers.normals[i]});
        }
    }
    return some;
}

}  // namespace sheen
