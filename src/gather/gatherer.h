// Gathering: what light arrives at sites. What their hemispheres see comes from rays or from the
// raster (ray_gather.h, raster_gather.h), each a class behind this interface.
#pragma once

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "gather/site.h"
#include "record/record.h"

namespace sheen {

class Anchors;
class Motion;
struct Life;
struct Strata;

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
    /// What would have been found in the next frame, as far as known motion tells (Motion); none
    /// where nothing that is seen moves.
    struct Later {
        vec3 irradiance{0.0f};
        std::vector<float> sh;  ///< likewise ShLayout
    };
    std::optional<Later> later = {};
    // Of records that live for some frames (cache/temporal.h).
    /// A few of the rays that saw it, and what they saw: cast again they tell whether it is so.
    struct Witness {
        vec3 direction{0.0f};
        float solid_angle = 0;  ///< that the ray stands for
        vec3 light{0.0f};
    };
    std::vector<Witness> witnesses = {};
    vec3 eye{0.0f};    ///< where they start
    int age = 0;       ///< frames since it was gathered
    int lifespan = 0;  ///< frames
    /// What will be known of it at its end; none unless temporal gradients are interpolated.
    std::shared_ptr<Life> life = {};
    /// What its rays met, so that its light can be followed (Gatherer::follow()); null: not kept.
    std::shared_ptr<Strata> strata = {};
};

/// Wall-clock time of a gather.
struct GatherSeconds {
    double see = 0;      ///< finding what the hemispheres see
    double project = 0;  ///< sums, gradients, spherical harmonics
};

/// What a gatherer keeps from call to call changes no result, but for anchors that rays are tied
/// to: these depend on the sites alone.
class Gatherer {
  public:
    Gatherer() = default;
    virtual ~Gatherer() = default;
    Gatherer(const Gatherer&) = delete;
    Gatherer& operator=(const Gatherer&) = delete;

    /// One result a site, in order.
    virtual std::vector<GatheredRecord> gather(std::span<const RecordSite> sites) = 0;

    /// From now on records have witnesses, and tell what they will see in the next frame
    /// (GatheredRecord::later), where the gatherer can; `motion` must outlive it.
    virtual void lookAheadBy(const Motion& motion) { static_cast<void>(motion); }
    /// By how much of itself the light at records has changed since they were gathered, as far as
    /// their witnesses tell: of diffuse ones the irradiance, of others what comes from any
    /// direction. 0 without witnesses.
    virtual std::vector<float> changesSince(std::span<const GatheredRecord* const> records) {
        return std::vector<float>(records.size(), 0.0f);
    }

    /// From now on records keep what their rays met (strata.h), where the gatherer can and their
    /// sites stand still; `anchors`, of the frame that has begun, must outlive it.
    virtual void keepStrata(Anchors& anchors) { static_cast<void>(anchors); }
    /// Brings records that have strata up to date: the light that they say is that of this frame.
    /// `turned`: nothing has changed but who looks at them, so that only what their lobes see does.
    virtual void follow(std::span<GatheredRecord* const> records, bool turned) {
        static_cast<void>(records);
        static_cast<void>(turned);
    }

    /// Time spent so far.
    GatherSeconds seconds() const { return seconds_; }

  protected:
    GatherSeconds seconds_;
};

}  // namespace sheen
