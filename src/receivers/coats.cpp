#include "receivers/coats.h"

#include "image/frame.h"

namespace sheen {
namespace {

// The same pixels, of which only the coats scatter light.
GBuffer coatsAlone(const GBuffer& gbuffer) {
    GBuffer coats;
    coats.image = gbuffer.image;
    coats.position = gbuffer.position;
    coats.depth = gbuffer.depth;
    coats.normal = gbuffer.normal;
    coats.mapped_normal = gbuffer.coat_normal;
    coats.roughness = gbuffer.coat_roughness;
    coats.f90 = gbuffer.coat;
    coats.primitive = gbuffer.primitive;
    coats.eye = gbuffer.eye;
    coats.diffuse = Image<vec3>(gbuffer.image.width, gbuffer.image.height);
    coats.f0 = Image<vec3>(gbuffer.image.width, gbuffer.image.height);
    for (size_t i = 0; i < coats.depth.pixels.size(); ++i) {
        const float weight = gbuffer.coat.pixels[i];
        if (weight > 0.0f) {
            coats.f0.pixels[i] = coatBrdf({.coat = weight}).f0;
        } else {
            coats.depth.pixels[i] = 0.0f;
            coats.primitive.pixels[i] = kNoPrimitive;
        }
    }
    return coats;
}

}  // namespace

Image<vec3> directWithCoats(const Tracer& tracer, const SceneLights& lights, const GBuffer& gbuffer,
                            std::span<const uint32_t> rows_of) {
    Image<vec3> direct = traceDirect(tracer, lights, gbuffer, rows_of);
    if (!gbuffer.coat.empty()) {
        const Image<vec3> of_coats = traceDirect(tracer, lights, coatsAlone(gbuffer), rows_of);
        for (size_t i = 0; i < direct.pixels.size(); ++i) {
            direct.pixels[i] += of_coats.pixels[i];
        }
    }
    return direct;
}

Receivers coatsOf(const Scene& scene, const GBuffer& gbuffer) {
    Receivers receivers = fieldsOf(coatsAlone(gbuffer));
    receivers.are_coats = true;
    const size_t count = receivers.positions.size();
    receivers.orders.assign(count, kNoOrder);
    receivers.by_rays.assign(count, 0);
    receivers.materials.assign(count, kNoMaterial);
    for (size_t i = 0; i < count; ++i) {
        if (receivers.seen(i)) {
            receivers.orders[i] = shared::DIFFUSE_ORDER;
            receivers.by_rays[i] = 1;
            receivers.materials[i] = static_cast<int>(scene.materials_of[receivers.triangles[i]]);
        }
    }
    return receivers;
}

}  // namespace sheen
