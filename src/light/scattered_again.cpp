#include "light/scattered_again.h"

#include <algorithm>
#include <utility>

#include "light/place_elements.h"

namespace sheen {
namespace {

// Rays of a cell near which nothing is kept.
constexpr int kGatherRows = 2, kGatherColumns = 4;

}  // namespace

ScatteredAgain::ScatteredAgain(const ScatteredOnce& once, std::unique_ptr<const KeptLight> kept,
                               const std::vector<Bounds>& near, int bounces)
    : OutgoingLight(once.tracer()),
      ways_(once, bounces),
      kept_(std::move(kept)),
      cells_(once.tracer(), near) {}

void ScatteredAgain::radiance(const Rays& rays, std::span<const Hit> hits, vec3* radiance) const {
    for (const Hit& hit : hits) {
        if (hit.found()) {
            cells_.prefetch(hit);
        }
    }
    const Asked asked = see(rays, hits, radiance,
                            bounces() == kAllBounces ? Lacking::kGathered : Lacking::kFollowed);
    asked_.fetch_add(asked.all, std::memory_order_relaxed);
    missed_.fetch_add(asked.missed, std::memory_order_relaxed);
}

ScatteredAgain::Asked ScatteredAgain::see(const Rays& rays, std::span<const Hit> hits,
                                          vec3* radiance, Lacking lacking) const {
    ways_.once().radiance(rays, hits, radiance);
    Asked asked;
    ways_.follow(
        rays, hits, [&](size_t ray, int, const vec3& light) { radiance[ray] += light; },
        [&](size_t ray, int followed, const WaysOn::Point& q, const vec3& weight,
            const vec3& lobe) {
            // Of a Lambertian surface what is reflected is kept, textures included; by the side of
            // the triangle alone, not by where it is seen from.
            const auto siteAt = [&](const vec2& uv) {
                const vec3 n_g = geometricNormal(scene(), static_cast<int>(q.hit.triangle));
                Hit hit = q.hit;
                hit.distance = 0.0f;  // the same from wherever it is met
                return elementSiteAt(scene(), hit, uv, hit.back ? -n_g : n_g);
            };
            const auto reflected = [&](const vec3& irradiance, const vec2& uv) {
                return q.glossy ? irradiance : irradiance * q.albedoAt(scene(), uv);
            };
            const auto find = [&](const vec2& uv) {
                const auto kept = kept_->irradiance(siteAt(uv), followed);
                return kept ? std::optional(reflected(*kept, uv)) : kept;
            };
            // Cells keep what is asked for where rays meet a surface first.
            const float area = rays.solidAngle(ray) * q.hit.distance * q.hit.distance;
            const auto cell = followed == 0 || bounces() == kAllBounces ? cells_.cellOf(q.hit, area)
                                                                        : std::nullopt;
            std::optional<vec3> kept = cell ? cells_.at(*cell, [&] { return find(cell->middle); })
                                            : find(vec2(q.hit.u, q.hit.v));
            ++asked.all;
            asked.missed += kept ? 0 : 1;
            if (!kept && cell && lacking == Lacking::kGathered) {
                kept = cells_.gatheredAt(*cell, [&] {
                    const vec3 irradiance = gathered(siteAt(cell->middle), cell->cell);
                    return reflected(irradiance, cell->middle);
                });
            }
            if (!kept) {
                return false;
            }
            radiance[ray] +=
                weight / kPi * *kept * (q.glossy ? q.albedo(scene()) + lobe : vec3(1.0f));
            return true;
        });
    return asked;
}

// The irradiance that other surfaces send. The seed is of the place.
vec3 ScatteredAgain::gathered(const ElementSite& site, uint32_t seed) const {
    const Looks looks(site, kGatherRows, kGatherColumns, seed);
    const Rays rays{.origin = site.side.start(),
                    .directions = looks.directions,
                    .solid_angles = looks.solid_angles};
    const size_t count = looks.directions.size();
    Hit hits[kGatherRows * kGatherColumns];
    vec3 light[kGatherRows * kGatherColumns];
    tracer().meet(rays, hits);
    see(rays, {hits, count}, light, Lacking::kFollowed);
    vec3 sum(0.0f);
    for (size_t i = 0; i < count; ++i) {
        // The sky's light, as that of lamps, is added where rays meet surfaces.
        sum += hits[i].found() && finite(light[i]) ? light[i] : vec3(0.0f);
    }
    return kPi / (kGatherRows * kGatherColumns) * sum;
}

double ScatteredAgain::lackingShare(std::span<const ElementSite> sites) const {
    const auto lacks = [this](const ElementSite& at) {
        return !kept_->irradiance(at, 0).has_value();
    };
    return static_cast<double>(std::count_if(sites.begin(), sites.end(), lacks)) /
           static_cast<double>(std::max<size_t>(sites.size(), 1));
}

double ScatteredAgain::missedShare() const {
    return static_cast<double>(missed_) / static_cast<double>(std::max<int64_t>(asked_, 1));
}

}  // namespace sheen
