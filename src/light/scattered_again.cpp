#include "light/scattered_again.h"

#include <algorithm>
#include <utility>

#include "light/place_elements.h"

namespace sheen {

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
    ways_.once().radiance(rays, hits, radiance);
    int64_t asked = 0, missed = 0;
    ways_.follow(
        rays, hits, [&](size_t ray, int, const vec3& light) { radiance[ray] += light; },
        [&](size_t ray, int followed, const WaysOn::Point& q, const vec3& weight,
            const vec3& lobe) {
            // Of a Lambertian surface what is reflected is kept, textures included; by the side of
            // the triangle alone, not by where it is seen from.
            const auto find = [&](const vec2& uv) {
                const vec3 n_g = geometricNormal(scene(), static_cast<int>(q.hit.triangle));
                const auto kept = kept_->irradiance(
                    elementSiteAt(scene(), q.hit, uv, q.hit.back ? -n_g : n_g), followed);
                return kept && !q.glossy ? std::optional(*kept * q.albedoAt(scene(), uv)) : kept;
            };
            // Cells keep what is asked for where rays meet a surface first.
            const float area = rays.solidAngle(ray) * q.hit.distance * q.hit.distance;
            const auto cell = followed == 0 || bounces() == kAllBounces ? cells_.cellOf(q.hit, area)
                                                                        : std::nullopt;
            const std::optional<vec3> kept =
                cell ? cells_.at(*cell, [&] { return find(cell->middle); })
                     : find(vec2(q.hit.u, q.hit.v));
            ++asked;
            if (!kept) {
                ++missed;
                return false;
            }
            radiance[ray] +=
                weight / kPi * *kept * (q.glossy ? q.albedo(scene()) + lobe : vec3(1.0f));
            return true;
        });
    asked_.fetch_add(asked, std::memory_order_relaxed);
    missed_.fetch_add(missed, std::memory_order_relaxed);
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
