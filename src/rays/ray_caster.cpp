#include "rays/ray_caster.h"

#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/error.h"
#include "rays/light_cells.h"
#include "rays/surface_point.h"

namespace sheen {
namespace {

constexpr int kPacket = RayCaster::kPacket;

// A shadow ray ends this fraction short of its light, so that a light lying on a surface is not
// hidden by it.
constexpr float kShadowRayShare = 1.0f - 1e-5f;

struct alignas(32) Mask {
    int lanes[kPacket] = {};  // -1: in use
};

RTCIntersectContext coherentContext() {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    return context;
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

// Sets a ray from a surface to a light, from where `light` arrives as `sample`.
void setShadowRay(RTCRay8& rays, int lane, const vec3& start, const PunctualLight& light,
                  const LightSample& sample) {
    if (sample.distance < 0.0f) {
        setRay(rays, lane, start, sample.wi, kInfinity);
    } else {
        const vec3 to_light = light.position - start;
        const float distance = std::max(glm::length(to_light), 1e-30f);
        setRay(rays, lane, start, to_light / distance, distance * kShadowRayShare);
    }
}

// Whether a shadow ray found nothing in its way: Embree sets tfar to -infinity where it did.
bool arrived(const RTCRay8& rays, int lane) { return rays.tfar[lane] >= 0.0f; }

}  // namespace

RayCaster::RayCaster(const Scene& scene) : scene_(scene) {
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

// What a ray met.
struct RayCaster::Hit {
    size_t ray;
    uint32_t triangle;
    float u, v;
    float distance;
    const LightCells::Cell* cell;  // null: nothing is known of its light
    uint32_t shade() const { return cell != nullptr ? cell->shade : ~0u; }
    uint32_t trace() const { return cell != nullptr ? cell->trace : ~0u; }
};

void RayCaster::cast(const Rays& rays, vec4* seen, const LightCells* cells, vec3* planes) const {
    // Few hits of a packet lack light; those of many packets fill packets of shadow rays. By then
    // the cells, which lie anywhere in memory, have arrived in the processor's cache.
    constexpr size_t kTogether = 32 * kPacket;
    Hit hits[kTogether];
    for (size_t first = 0; first < rays.directions.size(); first += kTogether) {
        const size_t end = std::min(first + kTogether, rays.directions.size());
        size_t count = 0;
        for (size_t packet = first; packet < end; packet += kPacket) {
            count += meet(rays, packet, std::min(packet + kPacket, end), cells, seen, planes,
                          hits + count);
        }
        for (size_t i = 0; i < count; ++i) {
            const Hit& hit = hits[i];
            const vec3 radiance =
                hit.cell != nullptr
                    ? hit.cell->radiance
                    : emissionAt(scene_, hit.triangle, vec3(1.0f - hit.u - hit.v, hit.u, hit.v));
            seen[hit.ray] = vec4(radiance, hit.distance);
        }
        const std::span<Hit> all(hits, count);
        const auto dark =
            std::partition(all.begin(), all.end(), [](const Hit& hit) { return hit.shade() != 0; });
        const auto known =
            std::partition(all.begin(), dark, [](const Hit& hit) { return hit.trace() != 0; });
        for (const std::span<Hit> lacking :
             {std::span(all.begin(), known), std::span(known, dark)}) {
            for (size_t i = 0; i < lacking.size(); i += kPacket) {
                light(rays, lacking.subspan(i, std::min<size_t>(kPacket, lacking.size() - i)),
                      seen);
            }
        }
    }
}

uint32_t RayCaster::reached(const PunctualLight& light, std::span<const Receiver> receivers) const {
    SHEEN_CHECK(receivers.size() <= kPacket);
    RTCIntersectContext context = coherentContext();
    Mask facing;
    alignas(32) RTCRay8 shadow;
    for (size_t i = 0; i < receivers.size(); ++i) {
        const Receiver& r = receivers[i];
        const LightSample sample = shared::sampleLight(light, r.position);
        if (glm::dot(r.n_g, sample.wi) > 0.0f && sample.irradiance != vec3(0.0f)) {
            const auto k = static_cast<int>(i);
            facing.lanes[k] = -1;
            setShadowRay(shadow, k, offSurface(r.position, r.n_g, r.toward_viewer, r.offset), light,
                         sample);
        }
    }
    rtcOccluded8(facing.lanes, embree_.get(), &context, &shadow);
    uint32_t reached = 0;
    for (int k = 0; k < kPacket; ++k) {
        reached |= facing.lanes[k] != 0 && arrived(shadow, k) ? 1u << k : 0u;
    }
    return reached;
}

std::optional<RayCaster::FirstHit> RayCaster::meetFirst(const vec3& origin,
                                                        const vec3& direction) const {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    RTCRayHit met{};
    met.ray.org_x = origin.x;
    met.ray.org_y = origin.y;
    met.ray.org_z = origin.z;
    met.ray.dir_x = direction.x;
    met.ray.dir_y = direction.y;
    met.ray.dir_z = direction.z;
    met.ray.tfar = kInfinity;
    met.ray.mask = 0xffffffffu;
    met.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    met.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(embree_.get(), &context, &met);
    if (met.hit.geomID == RTC_INVALID_GEOMETRY_ID) {
        return std::nullopt;
    }
    return FirstHit{
        .triangle = met.hit.primID, .u = met.hit.u, .v = met.hit.v, .distance = met.ray.tfar};
}

size_t RayCaster::meet(const Rays& rays, size_t first, size_t end, const LightCells* cells,
                       vec4* seen, vec3* planes, Hit* hits) const {
    RTCIntersectContext context = coherentContext();
    Mask cast;
    alignas(32) RTCRayHit8 met;
    for (size_t i = first; i < end; ++i) {
        const auto k = static_cast<int>(i - first);
        cast.lanes[k] = -1;
        setRay(met.ray, k, rays.origin, rays.directions[i], kInfinity);
        met.hit.geomID[k] = RTC_INVALID_GEOMETRY_ID;
        met.hit.instID[0][k] = RTC_INVALID_GEOMETRY_ID;
    }
    rtcIntersect8(cast.lanes, embree_.get(), &context, &met);

    size_t count = 0;
    for (size_t i = first; i < end; ++i) {
        const auto k = static_cast<int>(i - first);
        if (met.hit.geomID[k] == RTC_INVALID_GEOMETRY_ID) {
            seen[i] = vec4(0.0f);
            if (planes != nullptr) {
                planes[i] = vec3(0.0f);
            }
            continue;
        }
        Hit& hit = hits[count++];
        hit = {.ray = i,
               .triangle = met.hit.primID[k],
               .u = met.hit.u[k],
               .v = met.hit.v[k],
               .distance = met.ray.tfar[k],
               .cell = nullptr};
        const vec3 n_g(met.hit.Ng_x[k], met.hit.Ng_y[k], met.hit.Ng_z[k]);
        if (planes != nullptr) {
            planes[i] = n_g / (glm::dot(n_g, rays.directions[i]) * hit.distance);
        }
        if (cells != nullptr) {
            hit.cell =
                cells->find(hit.triangle, hit.u, hit.v, glm::dot(n_g, rays.directions[i]) > 0.0f,
                            rays.solidAngle(i) * hit.distance * hit.distance);
            __builtin_prefetch(hit.cell);
        }
    }
    return count;
}

void RayCaster::light(const Rays& rays, std::span<const Hit> hits, vec4* seen) const {
    RTCIntersectContext context = coherentContext();
    const auto count = static_cast<int>(hits.size());
    SurfacePoint points[kPacket];
    for (int k = 0; k < count; ++k) {
        const Hit& hit = hits[static_cast<size_t>(k)];
        points[k] = surfacePoint(scene_, hit.triangle, hit.u, hit.v, -rays.directions[hit.ray],
                                 hit.distance);
    }
    // Much of what is met lies in the dark: never asked.
    std::optional<Scatterer> surfaces[kPacket];
    for (size_t i = 0; i < scene_.lights.size(); ++i) {
        const uint32_t bit = LightCells::bit(i);
        const PunctualLight& light = scene_.lights[i];
        LightSample samples[kPacket];
        bool arrives[kPacket] = {};
        Mask traced;
        bool any_traced = false;
        alignas(32) RTCRay8 shadow;
        for (int k = 0; k < count; ++k) {
            const Hit& hit = hits[static_cast<size_t>(k)];
            const SurfacePoint& p = points[k];
            if ((hit.shade() & bit) == 0) {
                continue;
            }
            samples[k] = shared::sampleLight(light, p.position);
            arrives[k] =
                glm::dot(p.n_g, samples[k].wi) > 0.0f && samples[k].irradiance != vec3(0.0f);
            if (arrives[k] && (hit.trace() & bit) != 0) {
                traced.lanes[k] = -1;
                any_traced = true;
                setShadowRay(shadow, k, p.eye(scene_), light, samples[k]);
            }
        }
        if (any_traced) {
            rtcOccluded8(traced.lanes, embree_.get(), &context, &shadow);
        }
        for (int k = 0; k < count; ++k) {
            if (!arrives[k] || (traced.lanes[k] != 0 && !arrived(shadow, k))) {
                continue;
            }
            if (!surfaces[k]) {
                surfaces[k] = scattererAt(scene_, points[k]);
            }
            const size_t ray = hits[static_cast<size_t>(k)].ray;
            Scatterer surface = *surfaces[k];
            surface.brdf.alpha = shared::filteredAlpha(surface.brdf.alpha, rays.solidAngle(ray),
                                                       seen[ray].w, samples[k].distance);
            seen[ray] += vec4(scattered(surface, points[k].wo, samples[k]), 0.0f);
        }
    }
}

}  // namespace sheen
