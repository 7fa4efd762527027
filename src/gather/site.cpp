#include "gather/site.h"

#include <cmath>

#include "rays/jitter.h"

namespace sheen {
namespace {

// Of a triangle's side, in powers of two: what floats tell apart.
constexpr float kFinestSeeds = 20.0f;

// The same for all places of a cell of a triangle's barycentric coordinates, of about two
// footprints: so it does not change with the scene's scale, and seldom when the camera moves by
// much less.
uint32_t seedAt(const Scene& scene, uint32_t triangle, const vec3& position, float footprint) {
    const uvec3& t = scene.triangles[triangle];
    const vec3 d = position - scene.positions[t.x];
    const vec3 edges[2] = {scene.positions[t.y] - scene.positions[t.x],
                           scene.positions[t.z] - scene.positions[t.x]};
    const vec3 normal = glm::cross(edges[0], edges[1]);
    const vec2 barycentric =
        vec2(glm::dot(glm::cross(d, edges[1]), normal), glm::dot(glm::cross(edges[0], d), normal)) /
        glm::dot(normal, normal);
    uint32_t seed = pcgHash(triangle);
    for (int axis = 0; axis < 2; ++axis) {
        const float level = std::round(std::log2(glm::length(edges[axis]) / (2.0f * footprint)));
        const float cells = std::exp2(glm::clamp(level, 0.0f, kFinestSeeds));
        const float cell = glm::clamp(std::floor(barycentric[axis] * cells), -1.0f, cells);
        if (!std::isfinite(cell) || !std::isfinite(cells)) {
            continue;  // of a triangle without area, which has no such places
        }
        seed = pcgHash(seed + static_cast<uint32_t>(static_cast<int>(cell)));
        seed = pcgHash(seed + static_cast<uint32_t>(cells));
    }
    return seed;
}

}  // namespace

RecordSite siteAt(const Scene& scene, const Receivers& receivers, size_t i, bool on_bump) {
    const vec3& scattering = receivers.scatteringNormal(i);
    const vec3& normal = on_bump ? scattering : receivers.normals[i];
    const SurfaceSide p = receivers.sideAt(scene, i);
    RecordSite site{
        .position = p.position,
        .normal = normal,
        .geometric_normal = p.n_g,
        .toward_viewer = p.toward_viewer,
        .offset = p.offset,
        .seed = seedAt(scene, receivers.triangles[i], p.position, receivers.footprints[i]),
        .order = receivers.orders[i],
        .triangle = receivers.triangles[i]};
    if (!receivers.irradiance_only && !receivers.isTooGlossy(i) && normal == scattering) {
        const vec3& f0 = receivers.f0[i];
        site.lobe = {.alpha = receivers.alpha(i),
                     .f0 = (f0.x + f0.y + f0.z) / 3.0f,
                     .f90 = receivers.f90[i]};
    }
    return site;
}

}  // namespace sheen
