#include "rays/refraction.h"

#include <cmath>

#include "core/directions.h"
#include "scene/ggx_sampling.h"

namespace sheen {
namespace {

vec3 microfacetOf(const vec3& n, const vec3& wo, float roughness, const vec2& u) {
    const mat3 frame = tangentFrame(n);
    return frame * sampleGgxVisibleNormal(glm::transpose(frame) * wo,
                                          shared::alphaFromRoughness(roughness), u);
}

// On the side of the plane that `normal` points to.
vec3 keptOn(const vec3& normal, const vec3& direction) {
    const float height = glm::dot(normal, direction);
    return height < 0.0f ? direction - 2.0f * height * normal : direction;
}

}  // namespace

vec3 Passage::startOf(const Scene& scene, const SurfacePoint& p) const {
    const float offset = surfaceOffset(scene, p.triangle, p.position, p.n_g, p.distance);
    return offSurface(p.position, reflected ? p.n_g : -p.n_g, direction, offset);
}

Passage passageAt(const Scene& scene, const SurfacePoint& p, bool back,
                  const std::optional<vec2>& lobe) {
    const Material& material = scene.materials[scene.materials_of[p.triangle]];
    const vec3 along = -p.wo;
    const float roughness =
        lobe && material.blurs() ? materialAt(scene, p.triangle, p.barycentric).roughness : 0.0f;
    const bool rough = roughness > shared::MIN_ROUGHNESS;
    Passage passage{.direction = along, .outside = along};
    if (!material.refracts() && !rough) {
        return passage;
    }
    const vec3 n = normalsAt(scene, p.triangle, p.barycentric, p.n_g, p.wo).mapped;
    const vec3 facet = rough ? microfacetOf(n, p.wo, roughness, *lobe) : n;
    const vec3 mirrored = glm::reflect(along, facet);
    passage.bent = true;
    if (!material.refracts()) {
        passage.direction = keptOn(-p.n_g, glm::normalize(glm::reflect(mirrored, n)));
        return passage;
    }
    const vec3 refracted = glm::refract(along, facet, back ? material.ior : 1.0f / material.ior);
    if (refracted == vec3(0.0f)) {
        passage.reflected = true;
        passage.direction = keptOn(p.n_g, glm::normalize(mirrored));
        return passage;
    }
    passage.direction = keptOn(-p.n_g, glm::normalize(refracted));
    if (back) {
        passage.outside = passage.direction;
        passage.leaving = std::abs(glm::dot(n, passage.direction));
    }
    return passage;
}

}  // namespace sheen
