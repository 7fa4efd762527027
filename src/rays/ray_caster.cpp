#include "rays/ray_caster.h"

#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>

#include "core/error.h"
#include "scene/brdf_albedo.h"

namespace sheen {
namespace {

constexpr int kPacket = RayCaster::kPacket;

// A shadow ray ends this fraction short of its light, so that a light lying on a surface is not
// hidden by it.
constexpr float kShadowRayShare = 1.0f - 1e-5f;

struct alignas(32) Mask {
    int lanes[kPacket] = {};  // -1: in use
};

// Where a ray met the scene.
struct Met {
    uint32_t triangle;
    vec3 barycentric;
    vec3 position;
    vec3 n_g, wo;  // n_g on the side of wo, from where the ray came
};

Met metAt(const Scene& scene, uint32_t triangle, float u, float v, const vec3& wo) {
    const uvec3& t = scene.triangles[triangle];
    const vec3& p0 = scene.positions[t.x];
    const vec3& p1 = scene.positions[t.y];
    const vec3& p2 = scene.positions[t.z];
    const float w = 1.0f - u - v;
    return {.triangle = triangle,
            .barycentric = vec3(w, u, v),
            .position = w * p0 + u * p1 + v * p2,
            .n_g = shared::faceViewer(glm::normalize(glm::cross(p1 - p0, p2 - p0)), wo),
            .wo = wo};
}

// What is there; most of what rays meet lies in the dark and is never asked.
struct Surface {
    vec3 n;  // on the side of wo
    Brdf brdf;
};

Surface surfaceAt(const Scene& scene, const Met& met) {
    const uvec3& t = scene.triangles[met.triangle];
    const vec3& b = met.barycentric;
    const vec3 n = b.x * scene.normals[t.x] + b.y * scene.normals[t.y] + b.z * scene.normals[t.z];
    const float length = glm::length(n);
    Surface surface;
    surface.n = shared::shadingNormal(length > 1e-6f ? n / length : met.n_g, met.n_g, met.wo);
    const vec2 uv = b.x * scene.uvs[t.x] + b.y * scene.uvs[t.y] + b.z * scene.uvs[t.z];
    const MaterialParams material =
        materialAt(scene, scene.materials[scene.materials_of[met.triangle]], uv);
    // A Lambertian surface needs no albedo of a lobe it does not have.
    const bool lambertian = material.metallic == 0.0f && material.specular == 0.0f;
    surface.brdf = shared::makeBrdf(
        material,
        lambertian ? vec2(0.0f) : brdfAlbedo(glm::dot(surface.n, met.wo), material.roughness));
    return surface;
}

void setRay(RTCRay8& rays, int lane, const vec3& origin, const vec3& direction, float tfar) {
    rays.org_x[lane] = origin.x;
    rays.org_y[lane] = origin.y;
    rays.org_z[lane] = origin.z;
    rays.dir_x[lane] = direction.x;
    rays.dir_y[lane] = direction.y;
    rays.dir_z[lane] = direction.z;
    rays.tnear[lane] = 0.0f;
    rays.tfar[lane] = tfar;
    rays.time[lane] = 0.0f;
    rays.mask[lane] = 0xffffffffu;
    rays.id[lane] = 0;
    rays.flags[lane] = 0;
}

}  // namespace

RayCaster::RayCaster(const Scene& scene) : scene_(scene), offset_(surfaceOffset(scene)) {
    // One thread builds: Embree's parallel build orders triangles by the number of threads, and
    // the order decides which of two triangles owns a ray through their common edge.
    tbb::task_arena one_thread(1);
    one_thread.execute([this] { build(); });
}

void RayCaster::build() {
    device_.reset(rtcNewDevice(nullptr));
    if (!device_) {
        throwEnvironment("Embree cannot start (error {})",
                         static_cast<int>(rtcGetDeviceError(nullptr)));
    }
    embree_.reset(rtcNewScene(device_.get()));
    rtcSetSceneFlags(embree_.get(), RTC_SCENE_FLAG_ROBUST);
    bool allocated = true;
    if (!scene_.triangles.empty()) {
        RTCGeometry geometry = rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_TRIANGLE);
        void* vertices =
            rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                    sizeof(vec3), scene_.positions.size());
        void* indices =
            rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                    sizeof(uvec3), scene_.triangles.size());
        allocated = vertices != nullptr && indices != nullptr;
        if (allocated) {
            std::memcpy(vertices, scene_.positions.data(), scene_.positions.size() * sizeof(vec3));
            std::memcpy(indices, scene_.triangles.data(), scene_.triangles.size() * sizeof(uvec3));
            rtcCommitGeometry(geometry);
            rtcAttachGeometry(embree_.get(), geometry);
        }
        rtcReleaseGeometry(geometry);
    }
    rtcCommitScene(embree_.get());
    const RTCError error = rtcGetDeviceError(device_.get());
    if (!allocated || error != RTC_ERROR_NONE) {
        throwEnvironment("Embree cannot build its acceleration structure (error {}{})",
                         static_cast<int>(error),
                         error == RTC_ERROR_OUT_OF_MEMORY ? ", out of memory" : "");
    }
}

void RayCaster::cast(const vec3& origin, std::span<const vec3> directions, vec4* seen,
                     const float* solid_angles) const {
    for (size_t first = 0; first < directions.size(); first += kPacket) {
        const size_t count = std::min<size_t>(kPacket, directions.size() - first);
        castPacket(origin, directions.subspan(first, count), seen + first,
                   solid_angles != nullptr ? solid_angles + first : nullptr);
    }
}

void RayCaster::castPacket(const vec3& origin, std::span<const vec3> directions, vec4* seen,
                           const float* solid_angles) const {
    const auto count = static_cast<int>(directions.size());
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;

    // Find what the rays meet.
    Mask cast;
    alignas(32) RTCRayHit8 rays{};
    for (int k = 0; k < count; ++k) {
        cast.lanes[k] = -1;
        setRay(rays.ray, k, origin, directions[static_cast<size_t>(k)], kInfinity);
        rays.hit.geomID[k] = RTC_INVALID_GEOMETRY_ID;
        rays.hit.instID[0][k] = RTC_INVALID_GEOMETRY_ID;
    }
    rtcIntersect8(cast.lanes, embree_.get(), &context, &rays);
    Met met[kPacket];
    for (int k = 0; k < count; ++k) {
        if (rays.hit.geomID[k] == RTC_INVALID_GEOMETRY_ID) {
            cast.lanes[k] = 0;
            seen[k] = vec4(0.0f);
            continue;
        }
        met[k] = metAt(scene_, rays.hit.primID[k], rays.hit.u[k], rays.hit.v[k],
                       -directions[static_cast<size_t>(k)]);
        const Material& material = scene_.materials[scene_.materials_of[met[k].triangle]];
        seen[k] = vec4(material.params.emission, rays.ray.tfar[k]);
    }

    // Light it, with a shadow ray wherever a light would arrive.
    std::optional<Surface> surfaces[kPacket];
    for (const PunctualLight& light : scene_.lights) {
        Mask lit;
        alignas(32) RTCRay8 shadow{};
        LightSample arriving[kPacket];  // unshadowed
        for (int k = 0; k < count; ++k) {
            if (cast.lanes[k] == 0) {
                continue;
            }
            const Met& m = met[k];
            arriving[k] = shared::sampleLight(light, m.position);
            const LightSample& l = arriving[k];
            if (glm::dot(m.n_g, l.wi) <= 0.0f || l.irradiance == vec3(0.0f)) {
                continue;
            }
            lit.lanes[k] = -1;
            const vec3 start = this->origin(m.position, m.n_g, m.wo);
            if (l.distance < 0.0f) {
                setRay(shadow, k, start, l.wi, kInfinity);
            } else {
                const vec3 to_light = light.position - start;
                const float distance = std::max(glm::length(to_light), 1e-30f);
                setRay(shadow, k, start, to_light / distance, distance * kShadowRayShare);
            }
        }
        rtcOccluded8(lit.lanes, embree_.get(), &context, &shadow);
        for (int k = 0; k < count; ++k) {
            // Embree sets tfar to -infinity where something is in the way.
            if (lit.lanes[k] == 0 || shadow.tfar[k] < 0.0f) {
                continue;
            }
            const Met& m = met[k];
            if (!surfaces[k]) {
                surfaces[k] = surfaceAt(scene_, m);
            }
            const LightSample& l = arriving[k];
            const float NoL = glm::dot(surfaces[k]->n, l.wi);
            if (NoL <= 0.0f) {
                continue;
            }
            Brdf brdf = surfaces[k]->brdf;
            brdf.alpha =
                shared::filteredAlpha(brdf.alpha, solid_angles != nullptr ? solid_angles[k] : 0.0f,
                                      rays.ray.tfar[k], l.distance);
            seen[k] +=
                vec4(shared::evalBrdf(brdf, surfaces[k]->n, m.wo, l.wi) * l.irradiance * NoL, 0.0f);
        }
    }
}

}  // namespace sheen
