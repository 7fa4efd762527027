// What a record's hemisphere sees, turned into the record.
// Based on: [GKB09, 8.4], [WH92] for the gradients.
#pragma once

#include <span>
#include <vector>

#include "gather/gatherer.h"
#include "hemisphere/hemisphere.h"
#include "sh/sh.h"

namespace sheen {

/// Rows of a projectionMatrix() [coefficient][texel]: those that a record's radiance goes through,
/// and those for its gradients, a fit of their own with fewer bands. (The first bands of the larger
/// fit would not do: its bands cancel each other below the horizon, and where some are missing,
/// above.)
struct ShProjection {
    std::span<const float> value;
    std::span<const float> gradient;
};

/// What the texels of a record's hemisphere see.
struct SeenTexels {
    std::vector<vec4> light;  ///< radiance; w: distance, 0: nothing seen
    /// The planes of the surfaces seen, each by one ray through the texel, in the record's frame,
    /// whose z is its normal: along a unit direction d a plane lies at distance 1 / dot(plane, d).
    /// Zero where that ray met nothing; empty where planes are not known.
    std::vector<vec3> planes = {};
    /// By how much the record's frame is turned about its normal, radians: tangentFrame().
    float turn = 0.0f;
};

/// Turns what a record sees into the record: irradiance, gradients, harmonic mean distance and, for
/// order > 0, spherical harmonics through `projection`, which fits that order.
GatheredRecord integrateHemisphere(const Hemisphere& hemisphere, const SeenTexels& seen,
                                   const ShProjection& projection, const RecordSite& site);

/// What the site's lobe, if any, sees toward its viewer, texel by texel: the mean of their light by
/// the lobe's weights, so that constant light is met exactly. Unlike harmonics it keeps what is
/// narrow, as far as texels resolve it. `frame`: the record's. Nothing is told by texels that do
/// not cover the hemisphere.
void seeThroughLobe(const Hemisphere& hemisphere, std::span<const vec4> texels,
                    const RecordSite& site, const mat3& frame, GatheredRecord& result);

/// What spherical harmonics say of directions below a record's horizon.
enum class BelowHorizon {
    kContinued,  ///< what the horizon shows: for lobes that reach there (projectionMatrix())
    kNothing,    ///< that nothing comes from there: what light is, not what to look up
                 ///< (integralMatrix())
};

/// The matrices integrateHemisphere() projects with, each made when it is first asked for.
class ProjectionMatrices {
  public:
    explicit ProjectionMatrices(BelowHorizon below = BelowHorizon::kContinued) : below_(below) {}
    /// Makes those that `sites` need.
    void prepare(const Hemisphere& hemisphere, std::span<const RecordSite> sites);
    /// Empty for diffuse records.
    ShProjection of(int order) const {
        return {.value = of_[static_cast<size_t>(order)],
                .gradient = of_[static_cast<size_t>(shLayout(order).gradient_order)]};
    }

  private:
    BelowHorizon below_;
    std::vector<float> of_[shared::SH_MAX_ORDER + 1];
};

}  // namespace sheen
