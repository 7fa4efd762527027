// Gathering: what light arrives at sites. What their hemispheres see comes from rays or from the
// raster (ray_gather.h, raster_gather.h), each a class behind this interface.
#pragma once

#include <span>
#include <vector>

#include "gather/site.h"
#include "record/record.h"

namespace sheen {

/// What a gather found at a site, before any clamp of the radius.
struct GatheredRecord {
    Record record{};        ///< radius is the harmonic mean distance
    vec3 toward_viewer{};   ///< of its site
    std::vector<float> sh;  ///< ShLayout; empty for a diffuse record
    /// Greatest second derivative, in magnitude, of the irradiance's luminance along the surface.
    float curvature = 0;
    /// The mean of the light that the site's lobe sees, by the texels themselves; of the site's
    /// lobe, if any.
    vec3 lobe_light{};
    float lobe_texels =
        0;  ///< so many texels count in that mean: (sum of weights)^2 / sum of squares
    std::vector<Contrast> contrasts = {};  ///< the strongest, for records to come
};

/// Wall-clock time of a gather.
struct GatherSeconds {
    double see = 0;      ///< finding what the hemispheres see
    double project = 0;  ///< sums, gradients, spherical harmonics
};

/// What a gatherer keeps from call to call changes no result: these depend on the sites alone.
class Gatherer {
  public:
    Gatherer() = default;
    virtual ~Gatherer() = default;
    Gatherer(const Gatherer&) = delete;
    Gatherer& operator=(const Gatherer&) = delete;

    /// One result a site, in order.
    virtual std::vector<GatheredRecord> gather(std::span<const RecordSite> sites) = 0;

    /// Time spent so far.
    GatherSeconds seconds() const { return seconds_; }

  protected:
    GatherSeconds seconds_;
};

}  // namespace sheen
