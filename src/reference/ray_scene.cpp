#include "reference/ray_scene.h"

#include <tbb/task_arena.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>

#include "core/error.h"
#include "reference/sobol.h"
#include "scene/brdf_albedo.h"

namespace sheen {
namespace {

// A ray leaves its surface by this many units in the last place of the point's largest coordinate,
// which bound how rounding a hit moves it, and of what the vertices' coordinates add up to along
// the normal, which bounds how Embree's test of the triangle's plane errs: each of their products
// with the normal's by a few units. A plane along the axes thus costs nothing, however large it is,
// and all is the same fraction of the scene whatever the scene's scale. After [PJH23, 6.8].
constexpr float kOffsetUlps = 32.0f;
constexpr float kUlp = 0x1p-23f;

RTCRay makeRay(const vec3& origin, const vec3& direction, float tfar) {
    RTCRay ray{};
    ray.org_x = origin.x;
    ray.org_y = origin.y;
    ray.org_z = origin.z;
    ray.dir_x = direction.x;
    ray.dir_y = direction.y;
    ray.dir_z = direction.z;
    ray.tnear = 0.0f;
    ray.tfar = tfar;
    ray.mask = 0xffffffffu;
    return ray;
}

RTCRayHit makeRayHit(const RTCRay& ray) {
    RTCRayHit hit{};
    hit.ray = ray;
    hit.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    hit.hit.instID[0] = RTC_INVALID_GEOMETRY_ID;
    return hit;
}

RayHit hitOf(const RTCRayHit& ray) {
    if (ray.hit.geomID == RTC_INVALID_GEOMETRY_ID) {
        return {};
    }
    return {.triangle = ray.hit.primID, .u = ray.hit.u, .v = ray.hit.v};
}

// Glass that a ray is in, as far as it has come, and what that has left of its light.
class Inside {
  public:
    vec3 left{1.0f};

    // To that distance; infinite: it travels in none.
    void travelTo(float distance) {
        if (distance < kInfinity) {
            left *= absorbs_ == vec3(0.0f) ? vec3(1.0f) : glm::exp(-absorbs_ * (distance - at_));
            at_ = distance;
        }
    }
    // Where it has come to, through a surface's front; and through its back.
    void enter(const vec3& absorption) { absorbs_ += absorption; }
    void leave(const vec3& absorption) {
        if (glm::all(glm::lessThanEqual(absorption, absorbs_))) {
            absorbs_ -= absorption;
        } else {  // it has been in there from its start on
            left *= glm::exp(-absorption * at_);
        }
    }
    // Distances are told from where it has come to.
    void turn() { at_ = 0.0f; }

  private:
    vec3 absorbs_{0.0f};
    float at_ = 0.0f;
};

// In [0, 1), the same whenever the same point is hit.
float chanceAt(const RayHit& hit) {
    const uint32_t bits =
        hashCombine(hashCombine(hash32(hit.triangle), std::bit_cast<uint32_t>(hit.u)),
                    std::bit_cast<uint32_t>(hit.v));
    return static_cast<float>(bits >> 8) * 0x1p-24f;
}

// What is not there, a ray does not meet.
void rejectMasked(const RTCFilterFunctionNArguments* a) {
    const auto* scene = static_cast<const Scene*>(a->geometryUserPtr);
    for (unsigned int i = 0; i < a->N; ++i) {
        const float u = RTCHitN_u(a->hit, a->N, i), v = RTCHitN_v(a->hit, a->N, i);
        if (a->valid[i] != 0 &&
            coverageAt(*scene, RTCHitN_primID(a->hit, a->N, i), vec3(1.0f - u - v, u, v)) == 0.0f) {
            a->valid[i] = 0;
        }
    }
}

void setRay(RTCRay8& packet, size_t k, const ShadowRay& ray) {
    packet.org_x[k] = ray.origin.x;
    packet.org_y[k] = ray.origin.y;
    packet.org_z[k] = ray.origin.z;
    packet.dir_x[k] = ray.direction.x;
    packet.dir_y[k] = ray.direction.y;
    packet.dir_z[k] = ray.direction.z;
    packet.tnear[k] = 0.0f;
    packet.tfar[k] = ray.distance;
    packet.mask[k] = 0xffffffffu;
}

void checkEmbree(RTCDevice device, const char* doing) {
    const RTCError error = rtcGetDeviceError(device);
    if (error != RTC_ERROR_NONE) {
        throwEnvironment("Embree failed while {} (error {}{})", doing, static_cast<int>(error),
                         error == RTC_ERROR_OUT_OF_MEMORY ? ", out of memory" : "");
    }
}

}  // namespace

RayScene::RayScene(const Scene& scene) : scene_(scene) {
    n_g_.reserve(scene.triangles.size());
    for (int i = 0; i < scene.triangleCount(); ++i) {
        n_g_.push_back(geometricNormal(scene, i));
    }
    // Embree's parallel build orders primitives by the number of threads, and the order decides
    // which of two triangles owns a ray through their common edge. One thread builds: the image
    // never depends on the thread count.
    tbb::task_arena one_thread(1);
    one_thread.execute([this] { build(); });
}

void RayScene::build() {
    device_.reset(rtcNewDevice(nullptr));
    if (!device_) {
        throwEnvironment("Embree cannot start (error {})",
                         static_cast<int>(rtcGetDeviceError(nullptr)));
    }
    embree_.reset(rtcNewScene(device_.get()));
    rtcSetSceneFlags(embree_.get(), RTC_SCENE_FLAG_ROBUST);
    rtcSetSceneBuildQuality(embree_.get(), RTC_BUILD_QUALITY_MEDIUM);
    if (!scene_.triangles.empty()) {
        RTCGeometry geometry = rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_TRIANGLE);
        void* vertices =
            rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                    sizeof(vec3), scene_.positions.size());
        void* indices =
            rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                    sizeof(uvec3), scene_.triangles.size());
        checkEmbree(device_.get(), "allocating the geometry");
        std::memcpy(vertices, scene_.positions.data(), scene_.positions.size() * sizeof(vec3));
        std::memcpy(indices, scene_.triangles.data(), scene_.triangles.size() * sizeof(uvec3));
        for (const Material& material : scene_.materials) {
            blended_ = blended_ || material.blended;
            if (material.lightPasses()) {
                rtcSetGeometryUserData(geometry, const_cast<Scene*>(&scene_));
                rtcSetGeometryIntersectFilterFunction(geometry, &rejectMasked);
                rtcSetGeometryOccludedFilterFunction(geometry, &rejectMasked);
            }
        }
        rtcCommitGeometry(geometry);
        rtcAttachGeometry(embree_.get(), geometry);
        rtcReleaseGeometry(geometry);
    }
    rtcCommitScene(embree_.get());
    checkEmbree(device_.get(), "building the acceleration structure");
}

RTCRayHit RayScene::closest(const vec3& origin, const vec3& direction, float from, float to) const {
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    RTCRayHit ray = makeRayHit(makeRay(origin, direction, to));
    ray.ray.tnear = from;
    rtcIntersect1(embree_.get(), &context, &ray);
    return ray;
}

Crossing RayScene::crossing(const RayHit& hit, const vec3& direction) const {
    return crossingAt(scene_, hit.triangle, vec3(1.0f - hit.u - hit.v, hit.u, hit.v), direction);
}

RayHit RayScene::intersect(const vec3& origin, const vec3& direction) const {
    vec3 weight(1.0f);
    Inside inside;
    for (float from = 0.0f;;) {
        const RTCRayHit ray = closest(origin, direction, from, kInfinity);
        RayHit hit = hitOf(ray);
        inside.travelTo(ray.ray.tfar);
        const bool behind = hit.found() && fromBehind(hit, direction);
        if (behind) {
            inside.leave(absorptionOf(hit));
        }
        hit.weight = weight * inside.left;
        if (!blended_ || !hit.found()) {
            return hit;
        }
        const Crossing at = crossing(hit, direction);
        if (chanceAt(hit) < at.chance) {
            hit.weight *= at.weightOfMeeting();
            return hit;
        }
        weight *= at.weightOfPassing();
        if (!behind) {
            inside.enter(absorptionOf(hit));
        }
        from = std::nextafter(ray.ray.tfar, kInfinity);
    }
}

// How a camera's ray goes on that comes to glass.
struct RayScene::Turn {
    bool turns = false;  // else it goes straight on
    bool total = false;  // it is reflected, all of it
    vec3 origin{0.0f};
    vec3 along{0.0f};
    float leaving = 0.0f;  // of the body: the cosine outside

    // Of the ray outside of the body, or on its way there.
    const vec3& outside(const vec3& before) const { return leaving > 0.0f ? along : before; }
};

namespace {

// Snell's law: the part along the surface of a direction that comes to the side of the unit normal
// n grows by this ratio of the indices. None where it were longer than 1.
std::optional<vec3> refracted(const vec3& along, const vec3& n, float ratio) {
    const vec3 aside = ratio * (along - glm::dot(along, n) * n);
    const float down2 = 1.0f - glm::dot(aside, aside);
    return down2 > 0.0f ? std::optional(glm::normalize(aside - std::sqrt(down2) * n))
                        : std::nullopt;
}

vec3 mirroredBy(const vec3& n, const vec3& d) { return d - 2.0f * glm::dot(d, n) * n; }

// On the side of a plane that n, or if so its opposite, points to.
vec3 toSide(const vec3& n, bool opposite, const vec3& d) {
    return (glm::dot(n, d) < 0.0f) == opposite ? d : mirroredBy(n, d);
}

}  // namespace

RayScene::Turn RayScene::turnAt(const RayHit& hit, const vec3& along,
                                const std::optional<Facets>& facets) const {
    const Material& material = scene_.materials[scene_.materials_of[hit.triangle]];
    const bool bends = material.ior > 1.0f && material.transmits();
    if (!material.transmits() || (!bends && !facets)) {
        return {.along = along};
    }
    const Surface s = surfaceAt(hit, -along);
    vec3 h = s.n;
    if (facets && s.roughness > shared::MIN_ROUGHNESS) {
        const mat3 frame = tangentFrame(s.n);
        h = frame * sampleGgxVisibleNormal(glm::transpose(frame) * s.wo,
                                           shared::alphaFromRoughness(s.roughness),
                                           owenSobol(facets->index, facets->seed));
    } else if (!bends) {
        return {.along = along};
    }
    Turn turn{.turns = true};
    if (!bends) {  // a sheet: what it reflects, mirrored to the other side
        turn.along = toSide(s.n_g, true, glm::normalize(mirroredBy(s.n, mirroredBy(h, along))));
    } else {
        const bool outward = fromBehind(hit, along);
        const auto on = refracted(along, h, outward ? material.ior : 1.0f / material.ior);
        turn.total = !on;
        turn.along = on ? toSide(s.n_g, true, *on)
                        : toSide(s.n_g, false, glm::normalize(mirroredBy(h, along)));
        turn.leaving = on && outward ? std::abs(glm::dot(s.n, turn.along)) : 0.0f;
    }
    turn.origin = turn.total ? s.rayOrigin() : s.position - s.offset * s.n_g;
    return turn;
}

std::vector<Seen> RayScene::see(const vec3& origin, const vec3& direction,
                                const std::optional<Facets>& facets) const {
    constexpr int kMostTurns = 64;  // caught for longer, it goes straight on
    std::vector<Seen> seen;
    vec3 share(1.0f);
    float chance = 1.0f;
    Inside inside;
    vec3 eye = origin;
    vec3 along = direction;
    float from = 0.0f;
    std::optional<Facets> next = facets;
    for (int turns = 0;;) {
        const RTCRayHit ray = closest(eye, along, from, kInfinity);
        const RayHit hit = hitOf(ray);
        inside.travelTo(ray.ray.tfar);
        Seen part{.hit = hit, .direction = along, .share = share * inside.left, .chance = chance};
        if (!hit.found()) {
            seen.push_back(part);
            return seen;
        }
        const Material& material = scene_.materials[scene_.materials_of[hit.triangle]];
        const bool behind = fromBehind(hit, along);
        const bool unseen = behind && material.single_sided && !material.refracts();
        const Turn turn = unseen || turns == kMostTurns ? Turn{} : turnAt(hit, along, next);
        const vec3& absorption = absorptionOf(hit);
        if (behind) {
            inside.leave(absorption);
        }
        const vec3 left = inside.left;
        if (behind == turn.total) {
            inside.enter(absorption);
        }
        if (!turn.total && !unseen) {
            const Crossing at = blended_
                                    ? crossing(hit, turn.outside(along))
                                    : Crossing{.meets = 1.0f, .chance = 1.0f, .passes = vec3(0.0f)};
            part.share = share * left * at.meets;
            part.chance = chance * at.chance;
            part.leaving = turn.leaving;
            seen.push_back(part);
            share *= at.passes;
            chance *= 1.0f - at.chance;
            if (share == vec3(0.0f)) {
                return seen;
            }
        }
        from = turn.turns ? 0.0f : std::nextafter(ray.ray.tfar, kInfinity);
        if (turn.turns) {
            inside.turn();
            eye = turn.origin;
            along = turn.along;
            ++turns;
            if (next) {
                next->seed = hashCombine(next->seed, static_cast<uint32_t>(turns));
            }
        }
    }
}

vec3 RayScene::passing(const ShadowRay& shadow) const {
    if (!blended_) {
        RTCIntersectContext context;
        rtcInitIntersectContext(&context);
        RTCRay ray = makeRay(shadow.origin, shadow.direction, shadow.distance);
        rtcOccluded1(embree_.get(), &context, &ray);
        return vec3(ray.tfar < 0.0f ? 0.0f : 1.0f);  // Embree's sign for "something was hit"
    }
    vec3 share(1.0f);
    Inside inside;
    for (float from = 0.0f; share != vec3(0.0f);) {
        const RTCRayHit ray = closest(shadow.origin, shadow.direction, from, shadow.distance);
        const RayHit hit = hitOf(ray);
        if (!hit.found()) {
            break;
        }
        inside.travelTo(ray.ray.tfar);
        if (fromBehind(hit, shadow.direction)) {
            inside.leave(absorptionOf(hit));
        } else {
            inside.enter(absorptionOf(hit));
        }
        share *= crossing(hit, shadow.direction).passes;
        from = std::nextafter(ray.ray.tfar, kInfinity);
    }
    inside.travelTo(shadow.distance);
    return share * inside.left;
}

void RayScene::intersect(const vec3& origin, std::span<const vec3> directions, RayHit* hits) const {
    if (blended_) {
        std::transform(directions.begin(), directions.end(), hits,
                       [&](const vec3& direction) { return intersect(origin, direction); });
        return;
    }
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    alignas(32) int cast[kPacket] = {};
    alignas(32) RTCRayHit8 packet{};
    for (size_t k = 0; k < directions.size(); ++k) {
        cast[k] = -1;
        setRay(packet.ray, k, {origin, directions[k], kInfinity});
        packet.hit.geomID[k] = RTC_INVALID_GEOMETRY_ID;
        packet.hit.instID[0][k] = RTC_INVALID_GEOMETRY_ID;
    }
    rtcIntersect8(cast, embree_.get(), &context, &packet);
    for (size_t k = 0; k < directions.size(); ++k) {
        hits[k] =
            packet.hit.geomID[k] == RTC_INVALID_GEOMETRY_ID
                ? RayHit{}
                : RayHit{
                      .triangle = packet.hit.primID[k], .u = packet.hit.u[k], .v = packet.hit.v[k]};
    }
}

void RayScene::passing(std::span<const ShadowRay> rays, vec3* shares) const {
    if (blended_) {
        std::transform(rays.begin(), rays.end(), shares, [&](const ShadowRay& ray) {
            return ray.distance > 0.0f ? passing(ray) : vec3(1.0f);
        });
        return;
    }
    RTCIntersectContext context;
    rtcInitIntersectContext(&context);
    context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
    alignas(32) int cast[kPacket] = {};
    alignas(32) RTCRay8 packet{};
    for (size_t k = 0; k < rays.size(); ++k) {
        cast[k] = rays[k].distance > 0.0f ? -1 : 0;
        setRay(packet, k, rays[k]);
    }
    rtcOccluded8(cast, embree_.get(), &context, &packet);
    for (size_t k = 0; k < rays.size(); ++k) {
        shares[k] = vec3(cast[k] != 0 && packet.tfar[k] < 0.0f ? 0.0f : 1.0f);
    }
}

Surface RayScene::surfaceAt(const RayHit& hit, const vec3& wo, const PixelOf* pixel,
                            float leaving) const {
    const uvec3& t = scene_.triangles[hit.triangle];
    const vec3 &p0 = scene_.positions[t.x], &p1 = scene_.positions[t.y],
               &p2 = scene_.positions[t.z];
    Surface s;
    s.wo = wo;

    // In double, so that the point lies on the triangle's plane to within one rounding.
    const double u = hit.u, v = hit.v;
    s.position = vec3((1.0 - u - v) * glm::dvec3(p0) + u * glm::dvec3(p1) + v * glm::dvec3(p2));

    // Turn both normals to the viewer.
    const float w = 1.0f - hit.u - hit.v;
    s.n_g = shared::faceViewer(n_g_[hit.triangle], wo);
    const vec3 largest = glm::max(glm::abs(p0), glm::max(glm::abs(p1), glm::abs(p2)));
    s.offset = kOffsetUlps * kUlp * (maxAbs(s.position) + glm::dot(glm::abs(s.n_g), largest));
    const float footprint =
        pixel == nullptr ? 0.0f : pixelFootprint(pixel->camera, pixel->height, s.position, s.n_g);
    const vec3 at(w, hit.u, hit.v);
    const ShadingNormals normals = normalsAt(scene_, hit.triangle, at, s.n_g, wo, footprint);
    s.n = normals.mapped;

    // Look up the material.
    const MaterialParams material = materialAt(scene_, hit.triangle, at, footprint);
    // Only a Lambertian surface has no specular lobe, whatever the table says of one.
    const bool lambertian = material.specular == 0.0f && material.metallic == 0.0f;
    const float NoV = glm::dot(s.n, wo);
    const vec2 albedo_ab = lambertian ? vec2(0.0f) : brdfAlbedo(NoV, material.roughness);
    s.brdf = shared::makeBrdf(material, NoV, albedo_ab);
    if (const Layers layers = layersAt(scene_, hit.triangle, at, footprint); !layers.none()) {
        const float NoV_coat = glm::dot(normals.coat, wo);
        s.brdf = underLayers(s.brdf, layers, NoV, NoV_coat);
        if (layers.coat > 0.0f) {
            s.coat = {.brdf = coatBrdf(layers),
                      .n = normals.coat,
                      .albedo = coatAlbedo(layers, NoV_coat)};
        }
    }
    if (leaving > 0.0f) {
        s.brdf = fromWithin(s.brdf, material.roughness, leaving);
    }
    s.specular_albedo = s.brdf.f0 * albedo_ab.x + vec3(s.brdf.f90 * albedo_ab.y);
    s.emission = material.emission;
    s.roughness = material.roughness;
    return s;
}

}  // namespace sheen
