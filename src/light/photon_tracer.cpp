#include "light/photon_tracer.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <span>

#include "core/directions.h"
#include "core/parallel.h"
#include "light/photon_starts.h"
#include "light/punctual.h"
#include "light/sky.h"
#include "light/triangle_grid.h"
#include "rays/jitter.h"
#include "scene/ggx_sampling.h"

namespace sheen {
namespace {

// Some photons, one in so many and then again, find out where others are worth while.
constexpr int kPilots[] = {8, 8};
// Where a photon starts it chooses from so many ways to lights.
constexpr size_t kOffers = 2;
// Photons of more power than so many times the mean are split: at most as many are added as there
// are, over this.
constexpr double kMostPower = 4.0;
// And are at most so many: a photon may start a hair off a lamp.
constexpr double kMostCopies = 256.0;
// From surface to surface photons go on by chance, never surely.
constexpr float kLikeliest = 0.95f;

// Random numbers of a photon, by what they are for.
enum PhotonUse : uint32_t { kWhichPhoton, kWhere, kSource, kLamp, kLampPoint, kSky, kFirstLobe };

// A photon on its way.
struct Flight {
    vec3 origin, direction;
    vec3 power;
    uint32_t seed;
    size_t part;  // that it started from
};

// And one that lies where it is wanted.
struct Landed : Photon {
    size_t part;  // that it started from
};

class PhotonTracer {
  public:
    PhotonTracer(const Tracer& tracer, const SceneLights& lights, const PhotonPaths& paths)
        : tracer_(tracer),
          scene_(tracer.scene()),
          lights_(lights),
          sky_(scene_.environment),
          paths_(paths) {}

    struct Traced {
        std::vector<Landed> landed;
        double started = 0;  // power of all that started
    };
    // Those of `count` photons that lie where they are wanted, by random numbers of `seed`. One of
    // more power than `most` is as many photons as it is larger.
    Traced traceAll(const PhotonStarts& starts, int count, uint32_t seed, double most) const;

  private:
    struct Lit {
        vec3 wi{0.0f};
        vec3 irradiance{0.0f};  // by the shading normal
    };
    struct Offered : Lit {
        Way way;
    };
    Offered offered(const SurfaceSide& side, const vec3& n, uint32_t seed) const;
    Lit light(const SurfaceSide& side, const vec3& n, uint32_t seed) const;
    double start(const PhotonStarts& starts, int number, int count, uint32_t seed, double most,
                 std::vector<Flight>& flights) const;
    bool follows(const Scatterer& surface) const {
        return !paths_.caustics || isSpecular(surface.brdf);
    }
    bool wanted(const SurfacePoint& p, const Scatterer& surface) const;
    struct WayOn {
        vec3 wi;  // unit, z is the surface normal
        vec3 weight;
    };
    std::optional<WayOn> scatter(const Flight& arrived, const Brdf& brdf, const vec3& wo_local,
                                 uint32_t use) const;
    std::optional<Flight> leave(const Flight& arrived, const SurfacePoint& p,
                                const Scatterer& surface, const vec3& start, uint32_t use) const;
    void fly(std::span<const Flight> flights, int bounce, std::vector<Landed>& landed,
             std::vector<Flight>& next) const;

    const Tracer& tracer_;
    const Scene& scene_;
    const SceneLights& lights_;
    SkySampler sky_;
    const PhotonPaths paths_;
};

// Of all lights one, by chance, as likely as it would be bright at a point if nothing hid it.
PhotonTracer::Offered PhotonTracer::offered(const SurfaceSide& side, const vec3& n,
                                            uint32_t seed) const {
    Offered chosen;
    double sum = 0.0;
    double u = randomPlace(seed, kSource).x;
    // One of many by a single number: what is left of it decides again.
    const auto offer = [&](const vec3& wi, const vec3& normal_irradiance, const auto& way) {
        const float NoL = glm::dot(n, wi);
        if (NoL <= 0.0f || glm::dot(side.n_g, wi) <= 0.0f) {
            return;
        }
        const vec3 irradiance = NoL * normal_irradiance;
        const double weight = luminance(irradiance);
        if (!(weight > 0.0)) {
            return;
        }
        sum += weight;
        const double share = weight / sum;
        if (u < share) {
            chosen.wi = wi;
            chosen.irradiance = irradiance / static_cast<float>(weight);
            chosen.way = way();
            u /= share;
        } else {
            u = (u - share) / (1.0 - share);
        }
    };
    for (const PunctualLight& light : lights_.punctual.each()) {
        const LightSample s = shared::sampleLight(light, side.position);
        offer(s.wi, s.irradiance, [&] { return wayTo(light, s, side.start()); });
    }
    const vec2 which = randomPlace(seed, kLamp);
    if (!lights_.punctual.empty()) {
        if (const auto s = lights_.punctual.sample(side, n, which.y)) {
            offer(s->light.wi, s->light.irradiance, [&] { return s->way; });
        }
    }
    if (!lights_.lamps.empty()) {
        if (const auto s =
                lights_.lamps.sample(side, n, vec3(which.x, randomPlace(seed, kLampPoint)))) {
            offer(s->wi, s->radiance / s->density, [&] { return s->way; });
        }
    }
    if (!sky_.empty()) {
        const SkySampler::Sample s = sky_.sample(n, randomPlace(seed, kSky));
        if (s.density > 0.0f) {
            offer(s.wi, s.radiance / s.density, [&] {
                return Way{.start = side.start(), .direction = s.wi, .length = kInfinity};
            });
        }
    }
    chosen.irradiance *= static_cast<float>(sum);
    return chosen;
}

// And of several of these that nothing hides one, as likely as it is bright, for all of them.
PhotonTracer::Lit PhotonTracer::light(const SurfaceSide& side, const vec3& n, uint32_t seed) const {
    Offered all[kOffers];
    Way ways[kOffers];
    for (uint32_t k = 0; k < kOffers; ++k) {
        all[k] = offered(side, n, pcgHash(seed + k));
        ways[k] = all[k].way;
    }
    const Tracer::Shares shares = tracer_.passing(ways);
    float sums[kOffers];
    float sum = 0.0f;
    for (size_t k = 0; k < kOffers; ++k) {
        sum += luminancePassing(shares[k], all[k].irradiance);
        sums[k] = sum;
    }
    if (!(sum > 0.0f)) {
        return {};
    }
    const float u = sum * randomPlace(seed, kSource).y;
    size_t chosen = 0;
    while (chosen + 1 < kOffers && sums[chosen] <= u) {
        ++chosen;
    }
    const float mean = sum / kOffers;
    const vec3 arriving = shares[chosen] / maxAbs(shares[chosen]) * all[chosen].irradiance;
    return {.wi = all[chosen].wi, .irradiance = arriving * (mean / luminance(arriving))};
}

// Photon `number` of `count` at its first surface: lit, and on its way from there. Returns
// the power that it started with.
double PhotonTracer::start(const PhotonStarts& starts, int number, int count, uint32_t seed,
                           double most, std::vector<Flight>& flights) const {
    const uint32_t own = pcgHash(static_cast<uint32_t>(number) + pcgHash(seed));
    const auto [patch_index, probability] =
        starts.choose((number + double{randomPlace(own, kWhichPhoton).x}) / count);
    const Patch& patch = starts.patch(patch_index);
    const vec2 u = randomPlace(own, kWhere);
    const float root = std::sqrt(u.x);
    const vec2 e1 = patch.corners[1] - patch.corners[0], e2 = patch.corners[2] - patch.corners[0];
    const vec2 uv = patch.corners[0] + root * (1.0f - u.y) * e1 + root * u.y * e2;
    const vec3 by_winding = geometricNormal(scene_, static_cast<int>(patch.triangle));
    const vec3 n_g = patch.back ? -by_winding : by_winding;
    const SurfacePoint p = surfacePoint(scene_, patch.triangle, uv.x, uv.y, n_g, 0.0f);
    const SurfaceSide side{.position = p.position,
                           .n_g = n_g,
                           .toward_viewer = vec3(0.0f),
                           .offset = surfaceOffset(scene_, patch.triangle, p.position, n_g, 0.0f)};
    const Scatterer surface = scattererAt(scene_, p);
    const float coverage = coverageAt(scene_, patch.triangle, p.barycentric);
    if (!follows(surface) || coverage == 0.0f || probability <= 0.0) {
        return 0.0;
    }
    const Lit lit = light(side, surface.n, own);
    const double area =
        TriangleEdges(scene_, patch.triangle).area() * std::abs(e1.x * e2.y - e1.y * e2.x);
    const auto stands_for = static_cast<float>(coverage * area / (probability * count));
    // The light was weighed by the shading normal already.
    Flight arrived{.origin = side.start(),
                   .direction = -lit.wi,
                   .power = stands_for * lit.irradiance,
                   .seed = own,
                   .part = starts.partOf(patch_index)};
    const double power = luminance(arrived.power);
    if (!(power > 0.0) || !finite(arrived.power)) {
        return 0.0;
    }
    const double copies = glm::clamp(std::ceil(power / most), 1.0, kMostCopies);
    arrived.power /= static_cast<float>(copies);
    for (double copy = 0.0; copy < copies; ++copy) {
        if (const auto flight = leave(arrived, p, surface, side.start(), kFirstLobe)) {
            flights.push_back(*flight);
        }
        arrived.seed = pcgHash(arrived.seed);
    }
    return power;
}

// Whether photons that arrive there are kept.
bool PhotonTracer::wanted(const SurfacePoint& p, const Scatterer& surface) const {
    const bool scatters =
        !paths_.caustics || !isSpecular(surface.brdf) || surface.brdf.diffuse != vec3(0.0f);
    return scatters && (paths_.seen == nullptr || paths_.seen->contains(p.position));
}

// One way on of all that a surface reflects: along its lobe, and, where photons follow what is
// diffuse, by the cosine, as likely as each reflects.
std::optional<PhotonTracer::WayOn> PhotonTracer::scatter(const Flight& arrived, const Brdf& brdf,
                                                         const vec3& wo_local, uint32_t use) const {
    const vec2 u = randomPlace(arrived.seed, use);
    float by_lobe = 1.0f;
    if (!paths_.caustics) {
        const float diffuse = luminance(brdf.diffuse);
        const vec3 albedo = specularAlbedo(wo_local.z, std::sqrt(brdf.alpha), brdf.f0, brdf.f90);
        const float all = diffuse + luminance(albedo);
        by_lobe = all > 0.0f ? luminance(albedo) / all : 0.0f;
        if (static_cast<float>(pcgHash(arrived.seed + pcgHash(use))) * 0x1p-32f >= by_lobe) {
            return WayOn{.wi = cosineDirection(u), .weight = brdf.diffuse / (1.0f - by_lobe)};
        }
    }
    const auto along = sampleLobe(wo_local, brdf.alpha, brdf.f0, brdf.f90, u);
    return along ? std::optional(WayOn{.wi = along->wi, .weight = along->weight / by_lobe})
                 : std::nullopt;
}

// Along a way on, of which as much goes on as the surface reflects. Photons carry what the integral
// over paths from the eye has: shading normals count on the side of the light, geometric ones on
// the other [Vea97, 5.3].
std::optional<Flight> PhotonTracer::leave(const Flight& arrived, const SurfacePoint& p,
                                          const Scatterer& surface, const vec3& start,
                                          uint32_t use) const {
    const mat3 frame = tangentFrame(surface.n);
    const vec3 wo_local = glm::transpose(frame) * -arrived.direction;
    if (wo_local.z <= 0.0f) {
        return std::nullopt;
    }
    const auto along = scatter(arrived, surface.brdf, wo_local, use);
    if (!along) {
        return std::nullopt;
    }
    const vec3 direction = glm::normalize(frame * along->wi);
    const float cosine = glm::dot(direction, p.n_g);
    if (cosine <= 0.0f) {
        return std::nullopt;
    }
    Flight flight = arrived;
    flight.origin = start;
    flight.direction = direction;
    flight.power *= along->weight * (cosine / std::max(along->wi.z, 1e-6f));
    return luminance(flight.power) > 0.0f && finite(flight.power) ? std::optional(flight)
                                                                  : std::nullopt;
}

PhotonTracer::Traced PhotonTracer::traceAll(const PhotonStarts& starts, int count, uint32_t seed,
                                            double most) const {
    constexpr int kBatch = 1024;
    std::vector<Traced> batches(static_cast<size_t>((count + kBatch - 1) / kBatch));
    parallelFor(static_cast<int>(batches.size()), [&](int b) {
        Traced& batch = batches[static_cast<size_t>(b)];
        std::vector<Flight> flights;
        for (int i = b * kBatch; i < std::min((b + 1) * kBatch, count); ++i) {
            batch.started += start(starts, i, count, seed, most, flights);
        }
        for (int bounce = 1; !flights.empty(); ++bounce) {
            std::vector<Flight> next;
            for (size_t i = 0; i < flights.size(); i += Tracer::kPacket) {
                const size_t packet = std::min<size_t>(Tracer::kPacket, flights.size() - i);
                fly({&flights[i], packet}, bounce, batch.landed, next);
            }
            flights = std::move(next);
        }
    });
    Traced all;
    for (const Traced& batch : batches) {
        all.landed.insert(all.landed.end(), batch.landed.begin(), batch.landed.end());
        all.started += batch.started;
    }
    return all;
}

void PhotonTracer::fly(std::span<const Flight> flights, int bounce, std::vector<Landed>& landed,
                       std::vector<Flight>& next) const {
    vec3 origins[Tracer::kPacket];
    vec3 directions[Tracer::kPacket];
    Hit hits[Tracer::kPacket];
    for (size_t k = 0; k < flights.size(); ++k) {
        origins[k] = flights[k].origin;
        directions[k] = flights[k].direction;
    }
    tracer_.meet({.directions = {directions, flights.size()}, .origins = {origins, flights.size()}},
                 hits);
    for (size_t k = 0; k < flights.size(); ++k) {
        const Hit& hit = hits[k];
        if (!hit.found()) {
            continue;
        }
        Flight flight = flights[k];
        flight.power *= hit.weight;
        const SurfacePoint p =
            surfacePoint(scene_, hit.triangle, hit.u, hit.v, -flight.direction, hit.distance);
        const Scatterer surface = scattererAt(scene_, p);
        if (wanted(p, surface)) {
            landed.push_back({{.position = p.position,
                               .wi = p.wo,
                               .n_g = p.n_g,
                               .power = flight.power,
                               .triangle = p.triangle,
                               .scattered = bounce},
                              flight.part});
        }
        if (!follows(surface) || bounce >= paths_.bounces) {
            continue;
        }
        const float before = luminance(flight.power);
        flight.power *=
            std::max(glm::dot(surface.n, p.wo), 0.0f) / std::max(glm::dot(p.n_g, p.wo), 1e-6f);
        const uint32_t use = kFirstLobe + 2 * static_cast<uint32_t>(bounce);
        auto gone_on = leave(flight, p, surface, p.eye(scene_), use);
        if (!gone_on) {
            continue;
        }
        const float chance = std::min(luminance(gone_on->power) / before, kLikeliest);
        if (static_cast<float>(pcgHash(flight.seed + use + 1)) * 0x1p-32f < chance) {
            gone_on->power /= chance;
            next.push_back(*gone_on);
        }
    }
}

}  // namespace

std::vector<Photon> tracePhotons(const Tracer& tracer, const SceneLights& lights,
                                 const PhotonPaths& paths, int count) {
    const Scene& scene = tracer.scene();
    const bool lit = !scene.lights.empty() || !lights.lamps.empty() || !scene.environment.empty();
    const bool seen = paths.seen == nullptr || !paths.seen->empty();
    if (!lit || !seen || paths.bounces < 1) {
        return {};
    }
    PhotonStarts starts(scene, paths.caustics);
    if (starts.empty()) {
        return {};
    }
    const PhotonTracer photons(tracer, lights, paths);
    uint32_t seed = 0;
    double most = std::numeric_limits<double>::infinity();
    for (const int part : kPilots) {
        const PhotonTracer::Traced pilots = photons.traceAll(starts, count / part, ++seed, most);
        std::vector<double> light(starts.partCount());
        for (const Landed& photon : pilots.landed) {
            light[photon.part] += luminance(photon.power);
        }
        starts.heed(light);
        if (pilots.started > 0.0) {  // else they found nothing, and say nothing of the rest
            most = kMostPower * pilots.started / count;
        }
    }
    const std::vector<Landed> landed = photons.traceAll(starts, count, ++seed, most).landed;
    std::vector<Photon> result;
    result.reserve(landed.size());
    result.assign(landed.begin(), landed.end());  // without their parts
    return result;
}

}  // namespace sheen
