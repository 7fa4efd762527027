#include "light/scattered_once.h"

#include <algorithm>

#include "light/punctual.h"
#include "rays/jitter.h"
#include "rays/surface_point.h"

namespace sheen {

// A hit, and what is known of its light.
struct ScatteredOnce::Lit {
    size_t ray;
    const Hit* hit;
    const LightCells::Cell* cell;  // null: nothing

    uint32_t shade() const { return cell != nullptr ? cell->shade : ~0u; }
    uint32_t trace() const { return cell != nullptr ? cell->trace : ~0u; }
};

void ScatteredOnce::radiance(const Rays& rays, std::span<const Hit> hits, vec3* radiance) const {
    Lit lit[kTogether];
    size_t count = 0;
    for (size_t i = 0; i < hits.size(); ++i) {
        const Hit& hit = hits[i];
        if (!hit.found()) {
            radiance[i] = sky_.radiance(rays.directions[i]);
            continue;
        }
        const float area = rays.solidAngle(i) * hit.distance * hit.distance;
        lit[count++] = {
            .ray = i,
            .hit = &hit,
            .cell = cells_ ? cells_->find(hit.triangle, hit.u, hit.v, hit.back, area) : nullptr};
        // By the time that it is read, a cell, which lies anywhere in memory, has arrived.
        __builtin_prefetch(lit[count - 1].cell);
    }
    const std::span<Lit> all(lit, count);
    for (const Lit& l : all) {
        radiance[l.ray] = l.cell != nullptr ? l.cell->radiance : vec3(0.0f);
        const uint32_t triangle = l.hit->triangle;
        if (scene().materials[scene().materials_of[triangle]].emits() &&
            (lamps_ == nullptr || !lamps_->isLamp(triangle))) {
            radiance[l.ray] +=
                emissionAt(scene(), triangle, vec3(1.0f - l.hit->u - l.hit->v, l.hit->u, l.hit->v),
                           rays.solidAngle(l.ray) * l.hit->distance * l.hit->distance);
        }
    }
    const auto dark =
        std::partition(all.begin(), all.end(), [](const Lit& l) { return l.shade() != 0; });
    const auto known =
        std::partition(all.begin(), dark, [](const Lit& l) { return l.trace() != 0; });
    for (const std::span<Lit> lacking : {std::span(all.begin(), known), std::span(known, dark)}) {
        for (size_t i = 0; i < lacking.size(); i += Tracer::kPacket) {
            addPunctual(rays,
                        lacking.subspan(i, std::min<size_t>(Tracer::kPacket, lacking.size() - i)),
                        radiance);
        }
    }
    if ((lamps_ != nullptr && !lamps_->empty()) || !sky_.empty()) {
        for (size_t i = 0; i < all.size(); i += Tracer::kPacket) {
            addSampled(rays, all.subspan(i, std::min<size_t>(Tracer::kPacket, all.size() - i)),
                       radiance);
        }
    }
}

// Adds the punctual lights that a packet of hits lacks.
void ScatteredOnce::addPunctual(const Rays& rays, std::span<const Lit> lacking,
                                vec3* radiance) const {
    SurfacePoint points[Tracer::kPacket];
    for (size_t k = 0; k < lacking.size(); ++k) {
        const Hit& hit = *lacking[k].hit;
        points[k] =
            surfacePoint(scene(), hit.triangle, hit.u, hit.v, -rays.directions[lacking[k].ray],
                         hit.distance, rays.solidAngle(lacking[k].ray));
    }
    // Much of what is met lies in the dark: never asked.
    std::optional<Scatterer> surfaces[Tracer::kPacket];
    for (size_t i = 0; i < scene().lights.size(); ++i) {
        const uint32_t bit = LightCells::bit(i);
        const PunctualLight& light = scene().lights[i];
        LightSample samples[Tracer::kPacket];
        bool arrives[Tracer::kPacket] = {};
        Way ways[Tracer::kPacket];
        for (size_t k = 0; k < lacking.size(); ++k) {
            const SurfacePoint& p = points[k];
            if ((lacking[k].shade() & bit) == 0) {
                continue;
            }
            samples[k] = shared::sampleLight(light, p.position);
            arrives[k] =
                glm::dot(p.n_g, samples[k].wi) > 0.0f && samples[k].irradiance != vec3(0.0f);
            if (arrives[k] && (lacking[k].trace() & bit) != 0) {
                ways[k] = wayTo(light, samples[k], p.eye(scene()));
            }
        }
        const Tracer::Shares passing = tracer().passing({ways, lacking.size()});
        for (size_t k = 0; k < lacking.size(); ++k) {
            const float share = ways[k].length > 0.0f ? passing[k] : 1.0f;
            if (!arrives[k] || share == 0.0f) {
                continue;
            }
            if (!surfaces[k]) {
                surfaces[k] = scattererAt(scene(), points[k]);
            }
            const size_t ray = lacking[k].ray;
            Scatterer surface = *surfaces[k];
            surface.brdf.alpha =
                shared::filteredAlpha(surface.brdf.alpha, rays.solidAngle(ray),
                                      lacking[k].hit->distance, samples[k].distance);
            radiance[ray] += share * scattered(surface, points[k].wo, samples[k]);
        }
    }
}

// Adds, to a packet of hits, one sample of all lamps and one of the sky: many rays share a record,
// and average what chance adds to each.
void ScatteredOnce::addSampled(const Rays& rays, std::span<const Lit> lit, vec3* radiance) const {
    constexpr int kSources = 2;
    vec3 light[kSources][Tracer::kPacket];
    Way ways[kSources][Tracer::kPacket];
    for (size_t k = 0; k < lit.size(); ++k) {
        const Hit& hit = *lit[k].hit;
        const SurfacePoint p =
            surfacePoint(scene(), hit.triangle, hit.u, hit.v, -rays.directions[lit[k].ray],
                         hit.distance, rays.solidAngle(lit[k].ray));
        const SurfaceSide side{
            .position = p.position,
            .n_g = p.n_g,
            .toward_viewer = p.wo,
            .offset = surfaceOffset(scene(), hit.triangle, p.position, p.n_g, p.distance)};
        const Scatterer surface = scattererAt(scene(), p);
        const uint32_t seed = hashOfPoint(hit.triangle, hit.u, hit.v);
        const vec2 u = randomPlace(seed, 0), v = randomPlace(seed, 1);
        const auto arriving = [&](const vec3& wi, float distance, const vec3& irradiance) {
            Scatterer seen = surface;
            seen.brdf.alpha = shared::filteredAlpha(seen.brdf.alpha, rays.solidAngle(lit[k].ray),
                                                    hit.distance, distance);
            return scattered(seen, p.wo,
                             {.wi = wi, .distance = distance, .irradiance = irradiance});
        };
        if (lamps_ != nullptr) {
            if (const auto s = lamps_->sample(side, surface.n, vec3(u, v.x))) {
                light[0][k] = arriving(s->wi, s->distance, s->radiance / s->density);
                ways[0][k] = s->way;
            }
        }
        if (!sky_.empty()) {
            const SkySampler::Sample s = sky_.sample(surface.n, v);
            if (s.density > 0.0f && glm::dot(s.wi, p.n_g) > 0.0f) {
                light[1][k] = arriving(s.wi, -1.0f, s.radiance / s.density);
                ways[1][k] = {.start = side.start(), .direction = s.wi, .length = kInfinity};
            }
        }
    }
    for (int source = 0; source < kSources; ++source) {
        const Tracer::Shares passing = tracer().passing({ways[source], lit.size()});
        for (size_t k = 0; k < lit.size(); ++k) {
            radiance[lit[k].ray] += passing[k] > 0.0f ? passing[k] * light[source][k] : vec3(0.0f);
        }
    }
}

}  // namespace sheen
