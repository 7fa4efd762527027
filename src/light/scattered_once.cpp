#include "light/scattered_once.h"

#include <algorithm>

#include "light/punctual.h"
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
        radiance[i] = vec3(0.0f);
        if (!hit.found()) {
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
        const Hit& hit = *l.hit;
        radiance[l.ray] = l.cell != nullptr ? l.cell->radiance
                                            : emissionAt(scene(), hit.triangle,
                                                         vec3(1.0f - hit.u - hit.v, hit.u, hit.v));
    }
    const auto dark =
        std::partition(all.begin(), all.end(), [](const Lit& l) { return l.shade() != 0; });
    const auto known =
        std::partition(all.begin(), dark, [](const Lit& l) { return l.trace() != 0; });
    for (const std::span<Lit> lacking : {std::span(all.begin(), known), std::span(known, dark)}) {
        for (size_t i = 0; i < lacking.size(); i += Tracer::kPacket) {
            light(rays, lacking.subspan(i, std::min<size_t>(Tracer::kPacket, lacking.size() - i)),
                  radiance);
        }
    }
}

// Adds the punctual lights that a packet of hits lacks.
void ScatteredOnce::light(const Rays& rays, std::span<const Lit> lacking, vec3* radiance) const {
    SurfacePoint points[Tracer::kPacket];
    for (size_t k = 0; k < lacking.size(); ++k) {
        const Hit& hit = *lacking[k].hit;
        points[k] = surfacePoint(scene(), hit.triangle, hit.u, hit.v,
                                 -rays.directions[lacking[k].ray], hit.distance);
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
        const uint32_t free = tracer().free({ways, lacking.size()});
        for (size_t k = 0; k < lacking.size(); ++k) {
            if (!arrives[k] || (ways[k].length > 0.0f && (free >> k & 1u) == 0)) {
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
            radiance[ray] += scattered(surface, points[k].wo, samples[k]);
        }
    }
}

}  // namespace sheen
