#include "cache/pixel_light.h"

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
        seed = pcgHash(seed + static_cast<uint32_t>(static_cast<int>(cell)));
        seed = pcgHash(seed + static_cast<uint32_t>(cells));
    }
    return seed;
}

}  // namespace

RecordSite siteAt(const Scene& scene, const GBuffer& gbuffer, const PixelClasses& classes,
                  int pixel) {
    const auto i = static_cast<size_t>(pixel);
    const SurfaceSide p = gbuffer.sideAt(scene, pixel);
    const vec4& normal = gbuffer.normal.pixels[i];
    RecordSite site{
        .position = p.position,
        .normal = vec3(normal),
        .geometric_normal = p.n_g,
        .toward_viewer = p.toward_viewer,
        .offset = p.offset,
        .seed = seedAt(scene, gbuffer.primitive.pixels[i], p.position, gbuffer.footprintAt(pixel)),
        .order = classes.orders.pixels[i]};
    if (!classes.irradiance_only && !classes.isTooGlossy(pixel)) {
        const vec3 f0 = gbuffer.f0.pixels[i];
        site.lobe = {.alpha = shared::alphaFromRoughness(normal.w),
                     .f0 = (f0.x + f0.y + f0.z) / 3.0f,
                     .f90 = gbuffer.diffuse.pixels[i].w};
    }
    return site;
}

float outgoingLuminance(const GBuffer& gbuffer, const PixelClasses& classes,
                        const PixelLobes& lobes, const Record& record, const float* sh, int pixel) {
    const auto i = static_cast<size_t>(pixel);
    const vec3 p(gbuffer.position.pixels[i]);
    const vec3 irradiance = shared::recordIrradiance(record, p, vec3(gbuffer.normal.pixels[i]));
    const vec3 albedo = specularAlbedo(gbuffer, pixel);
    if (classes.irradiance_only || classes.isTooGlossy(pixel) || albedo == vec3(0.0f)) {
        return luminance(irradiance);
    }
    vec3 light = lobeLight(gbuffer, classes, lobes, record, sh, pixel);
    if (static_cast<int>(record.material) == classes.materials.pixels[i]) {
        light += shared::recordMissed(record);
    }
    return luminance(vec3(gbuffer.diffuse.pixels[i]) * irradiance / kPi +
                     albedo * glm::max(light, vec3(0.0f)));
}

vec3 lobeLight(const GBuffer& gbuffer, const PixelClasses& classes, const PixelLobes& lobes,
               const Record& record, const float* sh, int pixel) {
    const auto i = static_cast<size_t>(pixel);
    const vec3 p(gbuffer.position.pixels[i]);
    const int order = classes.orders.pixels[i];
    if (order == shared::DIFFUSE_ORDER) {
        return shared::recordIrradiance(record, p, vec3(gbuffer.normal.pixels[i])) / kPi;
    }
    const shared::ShVector lobe = lobes.at(pixel, order);
    return lobes.scale.pixels[i] * convolveRecord(record, sh, lobe.c, order, p) /
           glm::max(specularAlbedo(gbuffer, pixel), vec3(1e-12f));
}

}  // namespace sheen
