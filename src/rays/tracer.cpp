#include "rays/tracer.h"

#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <cstring>

#include "core/error.h"
#include "rays/absorption.h"
#include "rays/jitter.h"
#include "rays/refraction.h"

namespace sheen {
namespace {

constexpr int kPacket = Tracer::kPacket;

struct alignas(32) Mask {
    int lanes[kPacket] = {};  // -1: in use
};

// What a query makes of surfaces that light passes; filters get it by its first member.
struct Query {
    RTCIntersectContext context;
    bool meets_veils = false;  // else by chance
    uint32_t veiled = 0;       // bit k: a veil hides ray k, or more than one
    uint32_t glass = 0;        // bit k: ray k crosses glass

    explicit Query(RTCIntersectContextFlags flags) {
        rtcInitIntersectContext(&context);
        context.flags = flags;
    }
};

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
    rays.id[lane] = static_cast<unsigned int>(lane);
    rays.flags[lane] = 0;
}

Crossing crossingOf(const Scene& scene, const Hit& hit, const vec3& along) {
    return crossingAt(scene, hit.triangle, vec3(1.0f - hit.u - hit.v, hit.u, hit.v), along);
}

const Material& materialOf(const Scene& scene, const Hit& hit) {
    return scene.materials[scene.materials_of[hit.triangle]];
}

// body(k, point, crossing) for each ray of a packet that meets what light passes; where it returns
// false the ray goes on.
template <class F>
void filter(const RTCFilterFunctionNArguments* met, const F& body) {
    const Scene& scene = *static_cast<const Scene*>(met->geometryUserPtr);
    for (unsigned int k = 0; k < met->N; ++k) {
        if (met->valid[k] == 0) {
            continue;
        }
        const Hit hit{.triangle = RTCHitN_primID(met->hit, met->N, k),
                      .u = RTCHitN_u(met->hit, met->N, k),
                      .v = RTCHitN_v(met->hit, met->N, k)};
        const vec3 along(RTCRayN_dir_x(met->ray, met->N, k), RTCRayN_dir_y(met->ray, met->N, k),
                         RTCRayN_dir_z(met->ray, met->N, k));
        const Crossing crossing = crossingOf(scene, hit, along);
        if (crossing.chance < 1.0f && !body(k, hit, crossing)) {
            met->valid[k] = 0;
        }
    }
}

void filterMet(const RTCFilterFunctionNArguments* met) {
    auto& query = *reinterpret_cast<Query*>(met->context);
    const Scene& scene = *static_cast<const Scene*>(met->geometryUserPtr);
    filter(met, [&](unsigned int k, const Hit& hit, const Crossing& crossing) {
        if (query.meets_veils) {
            return crossing.chance > 0.0f;
        }
        const float chance =
            static_cast<float>(hashOfPoint(hit.triangle, hit.u, hit.v) >> 8u) * 0x1p-24f;
        query.glass |=
            materialOf(scene, hit).transmits() ? 1u << RTCRayN_id(met->ray, met->N, k) : 0u;
        return chance < crossing.chance;
    });
}

void filterHidden(const RTCFilterFunctionNArguments* met) {
    auto& query = *reinterpret_cast<Query*>(met->context);
    filter(met, [&](unsigned int k, const Hit&, const Crossing& crossing) {
        query.veiled |= crossing.chance > 0.0f ? 1u << RTCRayN_id(met->ray, met->N, k) : 0u;
        return false;
    });
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
                            [](const Material& m) { return m.lightPasses(); })) {
                // Embree hands the pointer back, and nothing writes to what it names.
                rtcSetGeometryUserData(geometry, const_cast<Scene*>(&scene_));
                rtcSetGeometryIntersectFilterFunction(geometry, &filterMet);
                rtcSetGeometryOccludedFilterFunction(geometry, &filterHidden);
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
    Query query(RTC_INTERSECT_CONTEXT_FLAG_COHERENT);
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
        query.glass = 0;
        rtcIntersect8(cast.lanes, embree_.get(), &query.context, &met);
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
            if ((query.glass >> k & 1u) != 0) {
                hits[i].weight = weightOf(rays.originOf(i), rays.directions[i], hits[i]);
            }
            if (planes != nullptr) {
                planes[i] = found ? n_g / (along * met.ray.tfar[k]) : vec3(0.0f);
            }
        }
    }
}

namespace {

// A camera's ray, as far as it has come.
struct Look {
    vec3 origin, direction;  // since it was bent last
    float before = 0.0f;     // how far it travelled until then
    float from = 0.0f;       // how far since
    int bends = 0;
    vec3 passing{1.0f};  // surfaces and bodies
    Absorption absorption;
    std::optional<vec2> lobe;

    explicit Look(const vec3& eye, const vec3& toward, const std::optional<vec2>& lobe_)
        : origin(eye), direction(toward), lobe(lobe_) {}

    void bend(const SurfacePoint& at, const Scene& scene, const Passage& passage) {
        passing *= absorption.passing(at.distance);
        absorption = absorption.onward();
        origin = passage.startOf(scene, at);
        direction = passage.direction;
        before += at.distance;
        from = 0.0f;
        ++bends;
        if (lobe) {  // another place for the next rough glass, which knows nothing of this one
            lobe = randomPlace(hashOfPoint(at.triangle, lobe->x, lobe->y), 0);
        }
    }
};

}  // namespace

Sight Tracer::seeAlone(const vec3& origin, const vec3& direction,
                       const std::optional<vec2>& lobe) const {
    constexpr float kDark = 1.0f / 512.0f;  // passes no light that shows
    Sight sight;
    Sight::Part& ground = sight.ground;
    Look look(origin, direction, lobe);
    for (;;) {
        ground = {.hit = meetAlone(look.origin, look.direction, look.from, kInfinity),
                  .origin = look.origin,
                  .direction = look.direction,
                  .before = look.before};
        const Hit& hit = ground.hit;
        if (!hit.found()) {
            ground.share = look.passing * look.absorption.passing(kInfinity);
            return sight;
        }
        const Material& material = materialOf(scene_, hit);
        look.from = std::nextafter(hit.distance, kInfinity);
        const auto cross_if = [&](bool side) {
            if (side) {
                look.absorption.cross(material, hit.back, hit.distance);
            }
        };
        Passage passage{.direction = look.direction, .outside = look.direction};
        SurfacePoint at{};
        // Caught for longer, as in a rim, light comes from somewhere: straight on.
        if (look.bends < Sight::kMostBends && bendsRays(material, look.lobe.has_value())) {
            at = surfacePoint(scene_, hit.triangle, hit.u, hit.v, -look.direction, hit.distance);
            passage = passageAt(scene_, at, hit.back, look.lobe);
            if (passage.reflected) {
                look.absorption.cross(material, true, hit.distance);
                look.bend(at, scene_, passage);
                look.absorption.cross(material, false, 0.0f);
                continue;
            }
        }
        cross_if(hit.back);
        ground.share = look.passing * look.absorption.passing(hit.distance);
        cross_if(!hit.back);
        if (hit.back && material.single_sided && !material.refracts()) {
            continue;
        }
        const Crossing crossing =
            material.blended ? crossingOf(scene_, hit, passage.outside)
                             : Crossing{.meets = 1.0f, .chance = 1.0f, .passes = vec3(0.0f)};
        ground.leaving = passage.leaving;
        if (maxAbs(crossing.passes * ground.share) < kDark ||
            sight.veil_count == Sight::kMostVeils) {
            return sight;
        }
        Sight::Part& veil = sight.veils[static_cast<size_t>(sight.veil_count++)];
        veil = ground;
        veil.share *= crossing.meets;
        look.passing *= crossing.passes;
        if (passage.bent) {
            look.bend(at, scene_, passage);
        }
    }
}

// From a distance on, up to another.
Hit Tracer::meetAlone(const vec3& origin, const vec3& direction, float from, float to) const {
    Query query(RTC_INTERSECT_CONTEXT_FLAG_INCOHERENT);
    query.meets_veils = true;
    RTCRayHit met{};
    met.ray.org_x = origin.x;
    met.ray.org_y = origin.y;
    met.ray.org_z = origin.z;
    met.ray.dir_x = direction.x;
    met.ray.dir_y = direction.y;
    met.ray.dir_z = direction.z;
    met.ray.tnear = from;
    met.ray.tfar = to;
    met.ray.mask = 0xffffffffu;
    met.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    met.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(embree_.get(), &query.context, &met);
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

// One by one: Embree asks filters in any order, of what lies behind the hit too.
vec3 Tracer::weightOf(const vec3& origin, const vec3& direction, const Hit& hit) const {
    vec3 weight(1.0f);
    Absorption absorption;
    for (float from = 0.0f;;) {
        const Hit crossed = meetAlone(origin, direction, from, hit.distance);
        if (!crossed.found() || crossed.triangle == hit.triangle) {
            break;
        }
        if (const Crossing crossing = crossingOf(scene_, crossed, direction);
            crossing.chance < 1.0f) {
            weight *= crossing.weightOfPassing();
        }
        absorption.cross(materialOf(scene_, crossed), crossed.back, crossed.distance);
        from = std::nextafter(crossed.distance, kInfinity);
    }
    if (hit.found() && hit.back) {
        absorption.cross(materialOf(scene_, hit), true, hit.distance);
    }
    weight *= absorption.passing(hit.distance);
    return hit.found() ? weight * crossingOf(scene_, hit, direction).weightOfMeeting() : weight;
}

// One by one: Embree may ask a filter of one occluder twice.
vec3 Tracer::passingVeils(const Way& way) const {
    vec3 share(1.0f);
    Absorption absorption;
    for (float from = 0.0f;;) {
        const Hit hit = meetAlone(way.start, way.direction, from, way.length);
        if (!hit.found()) {
            return share * absorption.passing(way.length);
        }
        share *= crossingOf(scene_, hit, way.direction).passes;
        absorption.cross(materialOf(scene_, hit), hit.back, hit.distance);
        from = std::nextafter(hit.distance, kInfinity);
    }
}

Tracer::Shares Tracer::passing(std::span<const Way> ways) const {
    SHEEN_CHECK(ways.size() <= kPacket);
    Shares passing{};
    Query query(RTC_INTERSECT_CONTEXT_FLAG_COHERENT);
    Mask asked;
    bool any = false;
    alignas(32) RTCRay8 rays;
    for (size_t i = 0; i < ways.size(); ++i) {
        if (ways[i].length > 0.0f) {
            const auto k = static_cast<int>(i);
            asked.lanes[k] = -1;
            passing[i] = vec3(1.0f);
            any = true;
            setRay(rays, k, ways[i].start, ways[i].direction, ways[i].length);
        }
    }
    if (!any) {
        return passing;
    }
    rtcOccluded8(asked.lanes, embree_.get(), &query.context, &rays);
    for (size_t k = 0; k < ways.size(); ++k) {
        // Embree sets tfar to -infinity where it found something.
        passing[k] = asked.lanes[k] != 0 && rays.tfar[k] < 0.0f ? vec3(0.0f) : passing[k];
        if (passing[k] != vec3(0.0f) && (query.veiled >> k & 1u) != 0) {
            passing[k] = passingVeils(ways[k]);
        }
    }
    return passing;
}

}  // namespace sheen
