// Where rays meet the scene, and what is there.
#pragma once

#include "scene/brdf_albedo.h"
#include "scene/scene.h"

namespace sheen {

/// A point of a triangle, seen from the direction wo.
struct SurfacePoint {
    uint32_t triangle;
    vec3 barycentric;
    vec3 position;
    vec3 n_g, wo;    ///< unit; n_g on the side of wo
    float distance;  ///< from where it is seen
    /// The area of the surface that the look stands for; 0: the point alone.
    float footprint = 0.0f;

    /// Where rays start that leave it.
    vec3 eye(const Scene& scene) const {
        return offSurface(position, n_g, wo,
                          surfaceOffset(scene, triangle, position, n_g, distance));
    }
};

/// The point at Embree's barycentric (u, v), seen from `distance` away. In double, so that it lies
/// on the triangle's plane to within one rounding, however large the triangle. `solid_angle`: of
/// the cone that the look stands for.
inline SurfacePoint surfacePoint(const Scene& scene, uint32_t triangle, float u, float v,
                                 const vec3& wo, float distance, float solid_angle = 0.0f) {
    const uvec3& t = scene.triangles[triangle];
    const vec3& p0 = scene.positions[t.x];
    const vec3& p1 = scene.positions[t.y];
    const vec3& p2 = scene.positions[t.z];
    SurfacePoint p;
    p.triangle = triangle;
    p.barycentric = vec3(1.0f - u - v, u, v);
    p.position = vec3((1.0 - u - v) * dvec3(p0) + double{u} * dvec3(p1) + double{v} * dvec3(p2));
    p.n_g = shared::faceViewer(glm::normalize(glm::cross(p1 - p0, p2 - p0)), wo);
    p.wo = wo;
    p.distance = distance;
    p.footprint = shared::footprintArea(solid_angle, distance, glm::dot(p.n_g, wo));
    return p;
}

/// A point of a surface, and the side of it that light arrives on or leaves from.
struct SurfaceSide {
    vec3 position;
    vec3 n_g, toward_viewer;  ///< unit; n_g on that side
    float offset;

    /// Where rays start that leave it.
    vec3 start() const { return offSurface(position, n_g, toward_viewer, offset); }
};

/// The side of a triangle's point that is seen from `eye`.
inline SurfaceSide sideToward(const Scene& scene, uint32_t triangle, const vec3& position,
                              const vec3& eye) {
    const vec3 way = eye - position;
    const vec3 n_g = shared::faceViewer(geometricNormal(scene, static_cast<int>(triangle)), way);
    const float distance = glm::length(way);
    return {.position = position,
            .n_g = n_g,
            .toward_viewer = way / distance,
            .offset = surfaceOffset(scene, triangle, position, n_g, distance)};
}

/// Whether light scatters alike in all directions.
inline bool isLambertian(const MaterialParams& material) {
    return material.metallic == 0.0f && material.specular == 0.0f;
}

/// Likewise of what lies on it, too.
inline bool isLambertian(const Material& material) {
    return isLambertian(material.params) && material.layers.none();
}

/// What scatters light at a point.
struct Scatterer {
    vec3 n;  ///< shading normal, unit, on the side of wo
    Brdf brdf;
};

/// Of the material that materialAt() finds at the point, under its layers; what its coat reflects
/// is left out.
inline Scatterer underLayersAt(const SurfacePoint& p, const MaterialParams& material,
                               const Layers& layers, const ShadingNormals& normals) {
    Scatterer surface{.n = normals.mapped, .brdf = {}};
    const float NoV = glm::dot(surface.n, p.wo);
    // A Lambertian surface needs no albedo of a lobe it does not have.
    surface.brdf = shared::makeBrdf(
        material, NoV, isLambertian(material) ? vec2(0.0f) : brdfAlbedo(NoV, material.roughness));
    if (!layers.none()) {
        surface.brdf = underLayers(surface.brdf, layers, NoV, glm::dot(normals.coat, p.wo));
    }
    return surface;
}

/// The same as rays see it: what the coat reflects of the light they find leaves in all directions.
inline Scatterer scattererAt(const Scene& scene, const SurfacePoint& p,
                             const MaterialParams& material) {
    const Layers layers = layersAt(scene, p.triangle, p.barycentric, p.footprint);
    const ShadingNormals normals =
        normalsAt(scene, p.triangle, p.barycentric, p.n_g, p.wo, p.footprint);
    Scatterer surface = underLayersAt(p, material, layers, normals);
    if (layers.coat > 0.0f) {
        surface.brdf.diffuse += coatAlbedo(layers, glm::dot(normals.coat, p.wo));
    }
    return surface;
}

inline Scatterer scattererAt(const Scene& scene, const SurfacePoint& p) {
    return scattererAt(scene, p, materialAt(scene, p.triangle, p.barycentric, p.footprint));
}

/// Radiance toward wo of the light that arrives, unshadowed.
inline vec3 scattered(const Scatterer& surface, const vec3& wo, const LightSample& light) {
    const float NoL = glm::dot(surface.n, light.wi);
    return NoL > 0.0f
               ? shared::evalBrdf(surface.brdf, surface.n, wo, light.wi) * light.irradiance * NoL
               : vec3(0.0f);
}

}  // namespace sheen
