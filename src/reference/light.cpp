#include "reference/light.h"

#include <cmath>

namespace sheen {
namespace {

// A shadow ray ends this fraction short of its light: a light lying on a surface is not hidden by
// it.
constexpr float kShadowRayShare = 1.0f - 1e-5f;

}  // namespace

bool finite(const vec3& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

bool black(const vec3& v) { return v.x == 0.0f && v.y == 0.0f && v.z == 0.0f; }

vec3 directRadiance(const RayScene& rays, const Surface& s, Counters& counters) {
    vec3 sum(0.0f);
    for (const PunctualLight& light : rays.scene().lights) {
        const LightSample sample = shared::sampleLight(light, s.position);
        const float NoL = glm::dot(s.n, sample.wi);
        if (NoL <= 0.0f || glm::dot(s.n_g, sample.wi) <= 0.0f) {
            continue;
        }
        const vec3 radiance =
            shared::evalBrdf(s.brdf, s.n, s.wo, sample.wi) * sample.irradiance * NoL;
        if (black(radiance)) {
            continue;
        }
        ++counters.rays;
        const vec3 origin = s.rayOrigin();
        bool hidden = false;
        if (sample.distance < 0.0f) {
            hidden = rays.occluded(origin, sample.wi, kInfinity);
        } else {
            const vec3 to_light = light.position - origin;
            const float distance = glm::length(to_light);
            hidden = distance > 0.0f &&
                     rays.occluded(origin, to_light / distance, distance * kShadowRayShare);
        }
        if (!hidden) {
            sum += radiance;
        }
    }
    return sum;
}

RayHit nextHit(const RayScene& rays, const Surface& s, const vec3& wi, Counters& counters) {
    if (glm::dot(s.n_g, wi) <= 0.0f) {
        return {};
    }
    ++counters.rays;
    return rays.intersect(s.rayOrigin(), wi);
}

Frame emptyFrame(int width, int height) {
    Frame frame;
    for (Image<vec3>* layer : {&frame.direct, &frame.indirect, &frame.indirect_diffuse,
                               &frame.emission, &frame.albedo, &frame.normal, &frame.position}) {
        *layer = Image<vec3>(width, height, vec3(0.0f));
    }
    frame.roughness = Image<float>(width, height, 0.0f);
    frame.depth = Image<float>(width, height, kInfinity);
    frame.primitive = Image<uint32_t>(width, height, kNoPrimitive);
    return frame;
}

std::optional<Surface> seePixel(const RayScene& rays, const Camera& camera, int x, int y,
                                Frame& frame, Counters& counters) {
    const CameraRay ray = cameraRay(camera, frame.width(), frame.height(), static_cast<float>(x),
                                    static_cast<float>(y));
    ++counters.rays;
    const RayHit hit = rays.intersect(ray.origin, ray.direction);
    if (!hit.found()) {
        return std::nullopt;
    }
    const Surface p = rays.surfaceAt(hit, -ray.direction);
    const vec3 forward = -vec3(camera.world_from_camera[2]);
    frame.primitive.at(x, y) = hit.triangle;
    frame.depth.at(x, y) = glm::dot(p.position - ray.origin, forward);
    frame.position.at(x, y) = p.position;
    frame.normal.at(x, y) = p.n;
    frame.albedo.at(x, y) = p.brdf.diffuse;
    frame.roughness.at(x, y) = p.roughness;
    frame.emission.at(x, y) = p.emission;
    const vec3 direct = directRadiance(rays, p, counters);
    if (finite(direct)) {
        frame.direct.at(x, y) = direct;
    } else {
        ++counters.nonfinite;
    }
    return p;
}

}  // namespace sheen
