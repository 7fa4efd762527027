#include "rays/tracer.h"

#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/error.h"

namespace sheen {
namespace {

constexpr int kPacket = Tracer::kPacket;

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

// Takes the holes of masks out of what rays meet.
void passHoles(const RTCFilterFunctionNArguments* met) {
    const Scene& scene = *static_cast<const Scene*>(met->geometryUserPtr);
    for (unsigned int k = 0; k < met->N; ++k) {
        if (met->valid[k] == 0) {
            continue;
        }
        const float u = RTCHitN_u(met->hit, met->N, k);
        const float v = RTCHitN_v(met->hit, met->N, k);
        if (isHole(scene, RTCHitN_primID(met->hit, met->N, k), vec3(1.0f - u - v, u, v))) {
            met->valid[k] = 0;
        }
    }
}

}  // namespace

Tracer::Tracer(const Scene& scene) : scene_(scene) {
    // One thread builds: Embree's parallel build orders triangles by the number of threads, and
    // the order decides which of two triangles owns a ray through their common edge.
    tbb::task_arena one_thread(1);
    one_thread.execute([this] { build(); });
}

void Tracer::build() {
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
            if (std::any_of(scene_.materials.begin(), scene_.materials.end(),
                            [](const Material& m) { return m.masked(); })) {
                // Embree hands the pointer back, and nothing writes to what it names.
                rtcSetGeometryUserData(geometry, const_cast<Scene*>(&scene_));
                rtcSetGeometryIntersectFilterFunction(geometry, &passHoles);
                rtcSetGeometryOccludedFilterFunction(geometry, &passHoles);
            }
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

void Tracer::meet(const Rays& rays, Hit* hits, vec3* planes) const {
    RTCIntersectContext context = coherentContext();
    const size_t count = rays.directions.size();
    for (size_t first = 0; first < count; first += kPacket) {
        const size_t end = std::min(first + kPacket, count);
        Mask cast;
        alignas(32) RTCRayHit8 met;
        for (size_t i = first; i < end; ++i) {
            const auto k = static_cast<int>(i - first);
            cast.lanes[k] = -1;
            setRay(met.ray, k, rays.originOf(i), rays.directions[i], kInfinity);
            met.hit.geomID[k] = RTC_INVALID_GEOMETRY_ID;
            met.hit.instID[0][k] = RTC_INVALID_GEOMETRY_ID;
        }
        rtcIntersect8(cast.lanes, embree_.get(), &context, &met);
        for (size_t i = first; i < end; ++i) {
            const auto k = static_cast<int>(i - first);
            const bool found = met.hit.geomID[k] != RTC_INVALID_GEOMETRY_ID;
            const vec3 n_g(met.hit.Ng_x[k], met.hit.Ng_y[k], met.hit.Ng_z[k]);
            const float along = glm::dot(n_g, rays.directions[i]);
            hits[i] = found ? Hit{.triangle = met.hit.primID[k],
                                  .u = met.hit.u[k],
                                  .v = met.hit.v[k],
                                  .distance = met.ray.tfar[k],
                                  .back = along > 0.0f}
                            : Hit{};
            if (planes != nullptr) {
                planes[i] = found ? n_g / (along * met.ray.tfar[k]) : vec3(0.0f);
            }
        }
    }
}

Hit Tracer::seeAlone(const vec3& origin, const vec3& direction) const {
    Hit hit = meetAlone(origin, direction, 0.0f);
    while (hit.back && scene_.materials[scene_.materials_of[hit.triangle]].single_sided) {
        hit = meetAlone(origin, direction, std::nextafter(hit.distance, kInfinity));
    }
    return hit;
}

// From a distance on.
Hit Tracer::meetAlone(const vec3& origin, const vec3& direction, float from) const {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    RTCRayHit met{};
    met.ray.org_x = origin.x;
    met.ray.org_y = origin.y;
    met.ray.org_z = origin.z;
    met.ray.dir_x = direction.x;
    met.ray.dir_y = direction.y;
    met.ray.dir_z = direction.z;
    met.ray.tnear = from;
    met.ray.tfar = kInfinity;
    met.ray.mask = 0xffffffffu;
    met.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    met.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(embree_.get(), &context, &met);
    if (met.hit.geomID == RTC_INVALID_GEOMETRY_ID) {
        return {};
    }
    const vec3 n_g(met.hit.Ng_x, met.hit.Ng_y, met.hit.Ng_z);
    return {.triangle = met.hit.primID,
            .u = met.hit.u,
            .v = met.hit.v,
            .distance = met.ray.tfar,
            .back = glm::dot(n_g, direction) > 0.0f};
}

uint32_t Tracer::free(std::span<const Way> ways) const {
    SHEEN_CHECK(ways.size() <= kPacket);
    RTCIntersectContext context = coherentContext();
    Mask asked;
    bool any = false;
    alignas(32) RTCRay8 rays;
    for (size_t i = 0; i < ways.size(); ++i) {
        if (ways[i].length > 0.0f) {
            const auto k = static_cast<int>(i);
            asked.lanes[k] = -1;
            any = true;
            setRay(rays, k, ways[i].start, ways[i].direction, ways[i].length);
        }
    }
    if (!any) {
        return 0;
    }
    rtcOccluded8(asked.lanes, embree_.get(), &context, &rays);
    uint32_t free = 0;
    for (int k = 0; k < kPacket; ++k) {
        // Embree sets tfar to -infinity where it found something.
        free |= asked.lanes[k] != 0 && rays.tfar[k] >= 0.0f ? 1u << k : 0u;
    }
    return free;
}

}  // namespace sheen
