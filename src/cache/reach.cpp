#include "cache/reach.h"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "receivers/creases.h"

namespace sheen {
namespace {

// Records that serve creases reach at most so much farther than the least, by which neighbours'
// footprints may differ.
constexpr float kCreaseReach = 1.1f;

float largestChange(const Record& r) {
    return luminance(
        {glm::length(r.translation_r), glm::length(r.translation_g), glm::length(r.translation_b)});
}

// Harmonic mean distance, limited by the relative change of irradiance. [WRC88]
float splitSphereRadius(const GatheredRecord& g) {
    const float change = largestChange(g.record);
    return change > 0.0f ? std::min(g.record.radius, luminance(g.record.irradiance) / change)
                         : g.record.radius;
}

// With gradients, extrapolation over d errs by c d^2 / 2, where c is the second derivative,
// relative to the irradiance [SJJ12]. What is to be made small for a given number of records is the
// sum of squared errors over the image, c^2 d^4 / 4, against 1 / d^2 records an area: at the
// least, c d^3 is the same everywhere, in heights of the image: of how many pixels it is made does
// not change how wrong it is. [SJJ12] makes each record's total the same, c d^4; pointwise c d^2
// would be (docs/decisions/placement.md compares them).
// It is not believed farther than the harmonic mean distance of what the record sees, over which
// all of that changes: what the record missed, or saw from a wrong place, has no curvature.
float hessianRadius(const GatheredRecord& g, const PlacementParams& params, float image_height) {
    float reach = g.record.radius;
    if (g.curvature > 0.0f) {
        const float relative = g.curvature / luminance(g.record.irradiance);
        const float tolerated = 2.0f * params.curvature * params.accuracy;
        reach = std::min(reach, std::cbrt(tolerated * image_height / relative));
    }
    return reach / params.accuracy;
}

}  // namespace

ReachBounds::ReachBounds(const Receivers& receivers, const PlacementParams& params)
    : receivers_(receivers), params_(params), creases_(findCreases(receivers)) {}

float ReachBounds::greatest(size_t i) const {
    const float pixels = isCrease(i) ? params_.min_pixels : params_.max_pixels;
    return pixels * receivers_.footprints[i] / params_.accuracy;
}

bool ReachBounds::mayServe(float radius, size_t i) const {
    return !isCrease(i) || radius <= kCreaseReach * greatest(i);
}

float allowedRadius(const GatheredRecord& found, const PlacementParams& params,
                    float image_height) {
    switch (params.control) {
        case ErrorControl::kSplitSphere:
            return splitSphereRadius(found);
        case ErrorControl::kHarmonic:
            return found.record.radius;
        case ErrorControl::kHessian:
            return hessianRadius(found, params, image_height);
    }
    throw std::logic_error("unknown error control");
}

// Where light changes within a pixel, at contacts and beside thin ledges, the least reach is more
// than it allows already: there a record serves no farther than it was placed for, or each pixel
// would take half of its light from its neighbours. (Where the least reach is several pixels, they
// have no records of their own that would be better.)
float servingRadius(float radius, float allowed, bool crease, const PlacementParams& params) {
    if (params.min_pixels > 1.0f) {
        return radius;
    }
    const float least = radius / params.overlap;
    return crease ? least : std::clamp(allowed, least, radius);
}

}  // namespace sheen
