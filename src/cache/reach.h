// How far a record reaches, by where it lies and by what it found itself; what its neighbours say
// of that is in placed_records.h. Based on: [WRC88], [SJJ12].
#pragma once

#include <vector>

#include "cache/placement_params.h"
#include "gather/gatherer.h"
#include "receivers/receivers.h"

namespace sheen {

/// Bounds of records' radii, by the receivers that they lie at.
class ReachBounds {
  public:
    /// Both must outlive it.
    ReachBounds(const Receivers& receivers, const PlacementParams& params);

    float least(float footprint) const { return params_.min_pixels * footprint / params_.accuracy; }
    float greatest(size_t i) const;
    bool isCrease(size_t i) const { return creases_[i] != 0; }
    /// Whether a receiver counts as served by a record: a crease only by one that reaches hardly
    /// farther than the least.
    bool mayServe(float radius, size_t i) const;

  private:
    const Receivers& receivers_;
    const PlacementParams& params_;
    const std::vector<uint8_t> creases_;
};

/// The radius that the error control asks for. `image_height`: Receivers::height() where the record
/// lies.
float allowedRadius(const GatheredRecord& found, const PlacementParams& params, float image_height);

/// By the serving weight, which reaches farther than the one that records are placed by: the radius
/// of a record that was placed with `radius`, where its light and its neighbours allow `allowed`.
float servingRadius(float radius, float allowed, bool crease, const PlacementParams& params);

}  // namespace sheen
