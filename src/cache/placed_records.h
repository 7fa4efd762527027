// Records as they are placed: each with a reach that its own light, its neighbours and what it may
// be at most allow. Based on: [KBPZ06] for neighbour clamping.
#pragma once

#include <array>
#include <vector>

#include "cache/coverage.h"
#include "cache/placement_params.h"
#include "cache/reach.h"
#include "cache/record_field.h"
#include "cache/record_tree.h"

namespace sheen {

class PlacedRecords {
  public:
    /// Places the records of the field. All must outlive it.
    PlacedRecords(const Scene& scene, const Receivers& receivers, const PlacementParams& params,
                  const RecordField& field);

    /// Places those that the field got since, in order: their reaches, and those of records around
    /// them, are as short as either asks for.
    void placeNew();

    const Receivers& receivers() const { return receivers_; }
    const PlacementParams& params() const { return params_; }
    const RecordField& field() const { return field_; }
    const Coverage& coverage() const { return coverage_; }
    NearestRecords nearestTo(const vec3& p) const;
    /// The radius a record at receiver i will most likely have: that of the nearest one placed so
    /// far, since neighbours on a surface have similar ones, within bounds.
    float predictedRadius(size_t i, size_t nearest) const;

    /// The field's records, in order, as they are to serve: gradients are bounded against the
    /// radius that they serve with.
    RecordCache handOver() const;

  private:
    // What becomes of the field's record of the same index.
    struct Placed {
        Record record;
        size_t receiver = 0;
        float footprint = 0;
        float allowed = 0;   // radius that its light and its neighbours allow, below any bound
        float outgoing = 0;  // luminance toward the viewer at its own receiver
    };

    void add(size_t index);
    void setMissed(size_t placed);
    float predictedOutgoing(size_t placed, size_t i) const;
    void heedNeighbours(size_t added);
    void limitRadius(size_t placed, float radius);
    void clampNeighbours(size_t added);

    const Receivers& receivers_;
    const PlacementParams& params_;
    const WeightParams weight_;
    const RecordField& field_;
    const ReachBounds bounds_;
    Coverage coverage_;
    std::vector<Placed> placed_;
    RecordTree tree_;
};

}  // namespace sheen
