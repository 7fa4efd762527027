// Gathering: what light arrives at a record. What its hemisphere sees comes from the raster or from
// rays (raster_gather.h, ray_gather.h); this turns it into a record.
// Based on: [GKB09, 8.4], [WH92] for the gradients.
#pragma once

#include <span>
#include <vector>

#include "cache/record.h"
#include "hemisphere/hemisphere.h"
#include "sh/sh.h"

namespace sheen {

/// Wall-clock time of a gather.
struct GatherSeconds {
    double see = 0;      ///< finding what the hemispheres see
    double project = 0;  ///< sums, gradients, spherical harmonics
};

/// Radiance and distance of a record's texels: RGB and w (0: nothing seen). Turns them into a
/// record: irradiance, gradients, harmonic mean distance and, for order > 0, spherical harmonics
/// through `projection` (of that order).
GatheredRecord integrateHemisphere(const Hemisphere& hemisphere, std::span<const vec4> texels,
                                   const std::vector<float>& projection, const RecordSite& site);

/// The matrices integrateHemisphere() projects with, each made when it is first asked for.
class ProjectionMatrices {
  public:
    /// Makes those that `sites` need.
    void prepare(const Hemisphere& hemisphere, std::span<const RecordSite> sites);
    /// Empty for diffuse records.
    const std::vector<float>& of(int order) const { return of_[static_cast<size_t>(order)]; }

  private:
    std::vector<float> of_[shared::SH_MAX_ORDER + 1];
};

}  // namespace sheen
