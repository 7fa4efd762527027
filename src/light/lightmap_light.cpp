#include "light/lightmap_light.h"

#include "rays/surface_point.h"

namespace sheen {

void LightmapLight::radiance(const Rays& rays, std::span<const Hit> hits, vec3* radiance) const {
    once_.radiance(rays, hits, radiance);
    for (size_t i = 0; i < hits.size(); ++i) {
        const Hit& hit = hits[i];
        if (!hit.found() || scene().materials[scene().materials_of[hit.triangle]].unlit) {
            continue;
        }
        const SurfacePoint p = surfacePoint(scene(), hit.triangle, hit.u, hit.v,
                                            -rays.directions[i], hit.distance, rays.solidAngle(i));
        const MaterialParams material = materialAt(scene(), p.triangle, p.barycentric, p.footprint);
        const Scatterer surface = scattererAt(scene(), p, material);
        const vec3 albedo =
            surface.brdf.diffuse + specularAlbedo(glm::dot(surface.n, p.wo), material.roughness,
                                                  surface.brdf.f0, surface.brdf.f90);
        radiance[i] += hit.weight * albedo * lightmapAt(scene(), p.triangle, p.barycentric) / kPi;
    }
}

}  // namespace sheen
