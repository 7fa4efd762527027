#include "light/ways_on.h"

#include <algorithm>
#include <array>
#include <optional>
#include <utility>
#include <vector>

#include "core/directions.h"
#include "light/place_elements.h"
#include "rays/jitter.h"
#include "scene/brdf_albedo.h"
#include "scene/ggx_sampling.h"

namespace sheen {
namespace {

// A way goes on by chance, by so much more often than by the share of light that is reflected: the
// fewer ways, the more each counts, and the more noise there is.
constexpr float kOftener = 1.5f;

// Of a record's ray the lobe is followed in as many ways as it stands for that many steradians.
// Beside a glossy wall half of all rays meet it, where its lobe may see something small and bright
// in one of thirty ways, and records there, which serve few pixels, have few rays.
constexpr float kAngleOfWay = 0.003f;
constexpr float kMostWays = 8.0f;

// What a way that goes on stands for, at the most: highlights seen over it are as wide as that.
// Were it all of what is reflected there, they would be too wide to send on all of their light.
constexpr float kWidest = 0.1f;

// Different random numbers of one hit; ScatteredOnce takes those before, what is kept those after.
enum Use : uint32_t { kLobe = 3, kDiffuse };

uint32_t seedOf(const Hit& hit) { return hashOfPoint(hit.triangle, hit.u, hit.v); }

// Of ways that go on, along lobes and by the cosine.
struct Chances {
    SpreadPlaces lobe, diffuse;

    explicit Chances(uint32_t seed) : lobe(seed, kLobe), diffuse(seed, kDiffuse) {}
};

float waysOf(float solid_angle) { return std::clamp(solid_angle / kAngleOfWay, 1.0f, kMostWays); }

// Ways that go on, together.
struct Ways {
    std::vector<size_t> of;  // ray
    std::vector<vec3> weights;
    std::vector<vec3> origins, directions;
    std::vector<float> solid_angles;

    Rays rays(size_t first, size_t count, bool without_caustics) const {
        return Rays{.directions = directions,
                    .solid_angles = solid_angles,
                    .origins = origins,
                    .without_caustics = without_caustics}
            .part(first, count);
    }
    void add(size_t ray, const vec3& weight, const vec3& origin, const vec3& direction,
             float solid_angle) {
        of.push_back(ray);
        weights.push_back(weight);
        origins.push_back(origin);
        directions.push_back(direction);
        solid_angles.push_back(solid_angle);
    }
};

// Goes on along the lobe, by chance, in so many ways on average where it reflects all light.
void followLobe(const Scene& scene, const WaysOn::Point& q, size_t ray, const vec3& weight,
                float most, SpreadPlaces& places, Ways& ways) {
    const Brdf& brdf = q.glossy->surface.brdf;
    const float wanted =
        most * std::min(kOftener * luminance(weight * q.glossy->specular_albedo), 1.0f);
    const mat3 frame = tangentFrame(q.glossy->surface.n);
    vec3 u = places.next();
    const auto count = static_cast<int>(wanted + u.z);
    for (int k = 0; k < count; ++k) {
        u = k > 0 ? places.next() : u;
        const auto along =
            sampleLobe(glm::transpose(frame) * q.wo, brdf.alpha, brdf.f0, brdf.f90, vec2(u));
        const vec3 direction = along ? glm::normalize(frame * along->wi) : vec3(0.0f);
        if (glm::dot(direction, q.glossy->p.n_g) > 0.0f) {
            ways.add(ray, weight * along->weight / wanted, q.glossy->p.eye(scene), direction,
                     std::min(1.0f / along->density, kWidest));
        }
    }
}

// And by the cosine.
void followDiffuse(const Scene& scene, const WaysOn::Point& q, size_t ray, const vec3& weight,
                   const vec3& u, Ways& ways) {
    const vec3 reflected = weight * q.albedo(scene);
    const float chance = std::min(kOftener * luminance(reflected), 1.0f);
    if (u.z >= chance) {
        return;
    }
    const ElementSite from = q.site(scene);
    const vec3 direction = glm::normalize(tangentFrame(from.normal) * cosineDirection(vec2(u)));
    if (glm::dot(direction, from.side.n_g) > 0.0f) {
        ways.add(ray, reflected / chance, from.side.start(), direction, kWidest);
    }
}

}  // namespace

WaysOn::Point::Point(const Scene& scene, const Hit& hit_, const vec3& wo_) : hit(hit_), wo(wo_) {
    if (isLambertian(scene.materials[scene.materials_of[hit.triangle]])) {
        return;
    }
    const SurfacePoint p = surfacePoint(scene, hit.triangle, hit.u, hit.v, wo, hit.distance);
    const MaterialParams material = materialAt(scene, p.triangle, p.barycentric);
    const Scatterer surface = scattererAt(scene, p, material);
    const Brdf& brdf = surface.brdf;
    glossy = {p, surface,
              specularAlbedo(glm::dot(surface.n, wo), material.roughness, brdf.f0, brdf.f90)};
}

vec3 WaysOn::Point::albedoAt(const Scene& scene, const vec2& uv) const {
    const MaterialParams material = materialAt(scene, hit.triangle, vec3(1.0f - uv.x - uv.y, uv));
    return (1.0f - material.transmission) * material.base_color;
}

vec3 WaysOn::Point::albedo(const Scene& scene) const {
    return glossy ? glossy->surface.brdf.diffuse : albedoAt(scene, vec2(hit.u, hit.v));
}

ElementSite WaysOn::Point::site(const Scene& scene) const {
    return elementSiteAt(scene, hit, vec2(hit.u, hit.v), wo);
}

int WaysOn::most() const { return std::min(kMost, bounces_ - 1); }

void WaysOn::follow(const Rays& rays, std::span<const Hit> hits, const Light& light,
                    const Ask& ask) const {
    const int most = this->most();
    // Ways by specular lobes alone, of rays that ask for no caustics, are the second.
    std::array<Ways, 2> next;
    // What rays from one point meet goes on in strata, set by set, the rest by chance of its own:
    // what led there is strata already.
    const auto found =
        std::find_if(hits.begin(), hits.end(), [](const Hit& h) { return h.found(); });
    if (found == hits.end()) {
        return;
    }
    std::vector<Chances> sets;
    for (uint32_t k = 0; k < (rays.sets.empty() ? 1 : Rays::kSets); ++k) {
        sets.emplace_back(pcgHash(k + seedOf(*found)));
    }
    const auto goOn = [&](const Hit& hit, const vec3& wo, size_t ray, int followed,
                          const vec3& weight, bool without_caustics, Chances& chances) {
        if (followed == bounces_ - 1) {
            return;  // scattered often enough
        }
        const Point q(scene(), hit, wo);
        const bool last = followed == most;
        const bool known = ask(ray, followed, q, weight,
                               last && q.glossy ? q.glossy->specular_albedo : vec3(0.0f));
        if (!last && !known) {
            followDiffuse(scene(), q, ray, weight, chances.diffuse.next(), next[0]);
        }
        if (!last && q.glossy) {
            const bool specular = without_caustics && isSpecular(q.glossy->surface.brdf);
            const float ways = followed == 0 ? waysOf(rays.solidAngle(ray)) : 1.0f;
            followLobe(scene(), q, ray, weight, ways, chances.lobe, next[specular ? 1 : 0]);
        }
    };
    for (size_t i = 0; i < hits.size(); ++i) {
        if (hits[i].found()) {
            std::optional<Chances> own;
            if (!rays.origins.empty()) {
                own.emplace(seedOf(hits[i]));
            }
            goOn(hits[i], -rays.directions[i], i, 0, hits[i].weight, rays.without_caustics,
                 own ? *own : sets[rays.setOf(i)]);
        }
    }
    const auto pursue = [&](const Ways& ways, int followed, bool without_caustics) {
        for (size_t first = 0; first < ways.of.size(); first += OutgoingLight::kTogether) {
            const size_t count = std::min(OutgoingLight::kTogether, ways.of.size() - first);
            const Rays cast = ways.rays(first, count, without_caustics);
            Hit met[OutgoingLight::kTogether];
            vec3 seen[OutgoingLight::kTogether];
            once_.tracer().meet(cast, met);
            once_.radiance(cast, {met, count}, seen);
            for (size_t i = 0; i < count; ++i) {
                // Lamps and the sky have already lit the surface that the way comes from.
                if (met[i].found()) {
                    const vec3& weight = ways.weights[first + i];
                    light(ways.of[first + i], followed, weight * seen[i]);
                    Chances chances(seedOf(met[i]));
                    goOn(met[i], -cast.directions[i], ways.of[first + i], followed,
                         met[i].weight * weight, without_caustics, chances);
                }
            }
        }
    };
    for (int followed = 1; !next[0].of.empty() || !next[1].of.empty(); ++followed) {
        const std::array<Ways, 2> ways = std::exchange(next, {});
        pursue(ways[0], followed, false);
        pursue(ways[1], followed, true);
    }
}

}  // namespace sheen
