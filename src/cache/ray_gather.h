// Gathering by rays: one through each texel of a record's hemisphere, at a random place within it,
// and more where light changes, as its neighbours and records nearby saw.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "cache/gather.h"
#include "rays/light_cells.h"
#include "rays/ray_caster.h"

namespace sheen {

/// Gathers on all threads; the results do not depend on how many there are. Which places the rays
/// take depends on how many records were gathered before. The caster and the cells must outlive it.
class RayGatherer {
  public:
    RayGatherer(const RayCaster& rays, const LightCells& cells, const HemisphereParams& params)
        : rays_(rays), cells_(cells), hemisphere_(makeHemisphere(params)) {}

    /// One result a site, in order.
    std::vector<GatheredRecord> gather(std::span<const RecordSite> sites);

    /// Time spent so far.
    GatherSeconds seconds() const { return seconds_; }
    /// Rays cast so far from records, those from what they met to the lights not counted.
    int64_t rays() const { return rays_cast_; }

  private:
    struct Seen {
        SeenTexels texels;
        std::vector<Contrast> contrasts;
        int64_t rays = 0;
    };
    Seen see(const RecordSite& site, uint32_t index, std::span<const Contrast> found) const;

    const RayCaster& rays_;
    const LightCells& cells_;
    Hemisphere hemisphere_;
    ProjectionMatrices projections_;
    uint32_t gathered_ = 0;
    int64_t rays_cast_ = 0;
    GatherSeconds seconds_;
};

}  // namespace sheen
