// Filling the field with what is missing: sites are chosen, gathered and placed until all receivers
// are served. How sites are chosen is handed in.
// Based on: [GKB09, algorithm 5], [WH92], [War94].
#pragma once

#include <span>
#include <vector>

#include "cache/placed_records.h"

namespace sheen {

/// Where a record is to be gathered.
struct SiteChoice {
    size_t receiver = 0;
    NearestRecords nearest = {};
    float radius = 0;    ///< predicted
    bool first = false;  ///< of the first there are: few have records nearby
};

/// A way to choose where records go.
class SiteChooser {
  public:
    SiteChooser() = default;
    virtual ~SiteChooser() = default;
    SiteChooser(const SiteChooser&) = delete;
    SiteChooser& operator=(const SiteChooser&) = delete;

    /// The next sites, which are gathered together, each at a receiver that is missed, or was when
    /// it was chosen; none where no receiver is.
    virtual std::vector<SiteChoice> next(const PlacedRecords& placed) = 0;
};

/// Gathers the sites that `chooser` names next, adds what was found to the field, the one that
/// `placed` places, and places it. Whether there were any.
bool fillOnce(const Scene& scene, PlacedRecords& placed, SiteChooser& chooser, Gatherer& gatherer,
              RecordField& field);

/// Thrown where filling takes too long.
struct OutOfTime {};

/// fillOnce() until nothing is missed. OutOfTime where sites are left to gather after so many
/// seconds; what was gathered stays in the field.
void fill(const Scene& scene, PlacedRecords& placed, SiteChooser& chooser, Gatherer& gatherer,
          RecordField& field, double seconds = kInfinity);

struct Placement {
    RecordCache cache;  ///< the field's records, in order, as they are to serve
    int uncovered = 0;  ///< receivers with a surface that no record serves: 0 where numbers are
                        ///< sound
};

/// Places the records of the field, then those that are missing as `params` says, which are added
/// to it; `seconds`: as fill() has it, from the call on.
Placement placeRecords(const Scene& scene, const Receivers& receivers,
                       const PlacementParams& params, Gatherer& gatherer, RecordField& field,
                       bool quiet, double seconds = kInfinity);

/// Records at those receivers, of the least reach and none to be placed: what strays (edges.h)
/// get that no record of the field serves.
RecordCache recordsAt(const Scene& scene, const Receivers& receivers,
                      std::span<const size_t> wanted, const PlacementParams& params,
                      Gatherer& gatherer);

}  // namespace sheen
