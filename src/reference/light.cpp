#include "reference/light.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "reference/sobol.h"

namespace sheen {
namespace {

// A shadow ray ends this fraction short of its light: a light lying on a surface is not hidden by
// it.
constexpr float kShadowRayShare = 1.0f - 1e-5f;

// Of the directions that the BRDF chooses for an estimate of lamps or sky.
constexpr uint32_t kBrdfSeed = 0x62726466u;

// What a light sends by way of a surface toward its wo if nothing is between them.
struct Arriving {
    Scattered light;
    ShadowRay way;  // of distance 0 where no ray is needed
};

Arriving arrivingFrom(const PunctualLight& light, const Surface& s) {
    const LightSample sample = shared::sampleLight(light, s.position);
    const float NoL = glm::dot(s.n, sample.wi);
    if ((NoL <= 0.0f && !s.coat) || glm::dot(s.n_g, sample.wi) <= 0.0f) {
        return {};
    }
    Arriving arriving;
    arriving.light.all = shared::evalBrdf(s.brdf, s.n, s.wo, sample.wi) * sample.irradiance * NoL;
    if (s.coat) {
        arriving.light.all += evalCoat(s.coat, s.wo, sample.wi) * sample.irradiance;
    }
    if (black(arriving.light.all)) {
        return {};
    }
    arriving.light.diffuse = s.brdf.diffuse / kPi * sample.irradiance * std::max(NoL, 0.0f);
    arriving.way = {.origin = s.rayOrigin(), .direction = sample.wi, .distance = kInfinity};
    if (sample.distance >= 0.0f) {
        const vec3 to_light = light.position - arriving.way.origin;
        const float distance = glm::length(to_light);
        arriving.way.distance = distance * kShadowRayShare;
        arriving.way.direction = distance > 0.0f ? to_light / distance : sample.wi;
    }
    return arriving;
}

}  // namespace

bool black(const vec3& v) { return v.x == 0.0f && v.y == 0.0f && v.z == 0.0f; }

Scattered scatterPunctual(const RayScene& rays, const Surface& s, Counters& counters) {
    Scattered sum;
    for (const PunctualLight& light : rays.scene().lights) {
        const Arriving arriving = arrivingFrom(light, s);
        if (black(arriving.light.all)) {
            continue;
        }
        ++counters.rays;
        const vec3 share = arriving.way.distance == 0.0f ? vec3(1.0f) : rays.passing(arriving.way);
        sum.add({.all = share * arriving.light.all, .diffuse = share * arriving.light.diffuse});
    }
    return sum;
}

vec3 directRadiance(const RayScene& rays, const Surface& s, Counters& counters) {
    return scatterPunctual(rays, s, counters).all;
}

void directRadiance(const RayScene& rays, std::span<const Surface> surfaces, vec3* radiance,
                    Counters& counters) {
    constexpr auto kPacket = static_cast<size_t>(RayScene::kPacket);
    SHEEN_CHECK(surfaces.size() <= kPacket);
    std::fill_n(radiance, surfaces.size(), vec3(0.0f));
    for (const PunctualLight& light : rays.scene().lights) {
        std::array<vec3, kPacket> unshadowed;
        std::array<ShadowRay, kPacket> ways;
        bool any = false;
        for (size_t k = 0; k < surfaces.size(); ++k) {
            const Arriving arriving = arrivingFrom(light, surfaces[k]);
            unshadowed[k] = arriving.light.all;
            ways[k] = arriving.way;
            if (!black(arriving.light.all)) {
                ++counters.rays;
                any = true;
            }
        }
        if (!any) {
            continue;
        }
        std::array<vec3, kPacket> shares;
        rays.passing({ways.data(), surfaces.size()}, shares.data());
        for (size_t k = 0; k < surfaces.size(); ++k) {
            radiance[k] += shares[k] != vec3(0.0f) ? shares[k] * unshadowed[k] : vec3(0.0f);
        }
    }
}

Scattered scatterChosen(const RayScene& rays, const Surface& s, const BrdfSampler& sampler,
                        const LightChoice& choice, Counters& counters) {
    const vec3& wi = choice.way.direction;
    const float NoL = glm::dot(s.n, wi);
    if (!(choice.pdf > 0.0f) || (!(NoL > 0.0f) && !s.coat) || !opensToward(s, wi)) {
        return {};
    }
    // The balance heuristic's weight over the density of the choice.
    const float density = choice.pdf + brdfPdf(sampler, s.brdf, s.n, s.wo, wi);
    const vec3 arriving = choice.radiance * (std::max(NoL, 0.0f) / density);
    Scattered scattered = {.all = shared::evalBrdf(s.brdf, s.n, s.wo, wi) * arriving,
                           .diffuse = s.brdf.diffuse / kPi * arriving};
    if (s.coat) {
        scattered.all += evalCoat(s.coat, s.wo, wi) * choice.radiance / density;
    }
    if (black(scattered.all)) {
        return {};
    }
    ++counters.rays;
    const vec3 share = rays.passing(choice.way);
    return {.all = share * scattered.all, .diffuse = share * scattered.diffuse};
}

vec3 lampMet(const Lights& lights, const Surface& q, uint32_t triangle, const vec3& from,
             float brdf_pdf) {
    return q.emission * balance(brdf_pdf, lights.lamps.pdf(triangle, q, from));
}

vec3 skyMet(const Lights& lights, const vec3& wi, float brdf_pdf) {
    return lights.sky.empty() ? vec3(0.0f)
                              : lights.sky.radiance(wi) * balance(brdf_pdf, lights.sky.pdf(wi));
}

vec3 lampsByBrdf(const RayScene& rays, const Lights& lights, const Surface& s,
                 const BrdfSampler& sampler, const vec2& u, Counters& counters) {
    const DirectionSample sample = sampleBrdf(sampler, s.brdf, s.n, s.wo, u);
    if (black(sample.weight)) {
        return vec3(0.0f);
    }
    const RayHit hit = nextHit(rays, s, sample.wi, counters);
    if (!hit.found() || !lights.lamps.contains(hit.triangle)) {
        return vec3(0.0f);
    }
    const Surface q = rays.surfaceAt(hit, -sample.wi);
    return sample.weight * hit.weight * lampMet(lights, q, hit.triangle, s.rayOrigin(), sample.pdf);
}

vec3 sampleLamps(const RayScene& rays, const Lights& lights, const Surface& s,
                 const BrdfSampler& sampler, uint32_t index, uint32_t seed, Counters& counters) {
    const LightChoice choice = lights.lamps.choose(s.rayOrigin(), owenSobol(index, seed));
    return scatterChosen(rays, s, sampler, choice, counters).all +
           lampsByBrdf(rays, lights, s, sampler, owenSobol(index, hashCombine(seed, kBrdfSeed)),
                       counters);
}

vec3 sampleSky(const RayScene& rays, const Lights& lights, const Surface& s,
               const BrdfSampler& sampler, uint32_t index, uint32_t seed, Counters& counters) {
    const LightChoice choice = lights.sky.choose(s.rayOrigin(), owenSobol(index, seed));
    vec3 radiance = scatterChosen(rays, s, sampler, choice, counters).all;
    const DirectionSample by_brdf =
        sampleBrdf(sampler, s.brdf, s.n, s.wo, owenSobol(index, hashCombine(seed, kBrdfSeed)));
    if (!black(by_brdf.weight) && opensToward(s, by_brdf.wi)) {
        if (const RayHit hit = nextHit(rays, s, by_brdf.wi, counters); !hit.found()) {
            radiance += by_brdf.weight * hit.weight * skyMet(lights, by_brdf.wi, by_brdf.pdf);
        }
    }
    return radiance;
}

RayHit nextHit(const RayScene& rays, const Surface& s, const vec3& wi, Counters& counters) {
    if (!opensToward(s, wi)) {
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

std::vector<Sighting> look(const RayScene& rays, const Camera& camera, const ivec2& size,
                           const vec2& place, Textures textures, Counters& counters,
                           const std::optional<Facets>& facets) {
    const CameraRay ray = cameraRay(camera, size.x, size.y, place.x, place.y);
    const Environment& sky = rays.scene().environment;
    ++counters.rays;
    const RayScene::PixelOf pixel{.camera = camera, .height = size.y};
    std::vector<Sighting> parts;
    for (const Seen& seen : rays.see(ray.origin, ray.direction, facets)) {
        Sighting part{.share = seen.share, .chance = seen.chance};
        if (seen.hit.found()) {
            part.surface =
                rays.surfaceAt(seen.hit, -seen.direction,
                               textures == Textures::kOfPixel ? &pixel : nullptr, seen.leaving);
            part.triangle = seen.hit.triangle;
            part.emission = part.surface->emission;
        } else if (sky.shows()) {
            part.emission = sky.radiance(seen.direction);
        }
        parts.push_back(part);
    }
    return parts;
}

void addLight(const RayScene& rays, const Sighting& part, int x, int y, Frame& frame,
              Counters& counters) {
    frame.emission.at(x, y) += part.share * part.emission;
    const vec3 direct =
        part.surface ? part.share * directRadiance(rays, *part.surface, counters) : vec3(0.0f);
    if (finite(direct)) {
        frame.direct.at(x, y) += direct;
    } else {
        ++counters.nonfinite;
    }
}

void setGBuffer(const Camera& camera, const Sighting& part, int x, int y, Frame& frame) {
    const Surface& p = *part.surface;
    const vec3 origin = cameraRay(camera, frame.width(), frame.height(), static_cast<float>(x),
                                  static_cast<float>(y))
                            .origin;
    const vec3 forward = -vec3(camera.world_from_camera[2]);
    frame.primitive.at(x, y) = part.triangle;
    frame.depth.at(x, y) = glm::dot(p.position - origin, forward);
    frame.position.at(x, y) = p.position;
    frame.normal.at(x, y) = p.n;
    frame.albedo.at(x, y) = p.brdf.diffuse;
    frame.roughness.at(x, y) = p.roughness;
}

std::optional<Surface> seePixel(const RayScene& rays, const Camera& camera, int x, int y,
                                Frame& frame, Counters& counters) {
    const ivec2 size(frame.width(), frame.height());
    Sighting nearest = look(rays, camera, size, vec2(x, y), Textures::kOfPixel, counters).front();
    nearest.share = vec3(1.0f);
    addLight(rays, nearest, x, y, frame, counters);
    if (nearest.surface) {
        setGBuffer(camera, nearest, x, y, frame);
    }
    return nearest.surface;
}

}  // namespace sheen
