// Records that live for some frames: how long, what they say meanwhile, and who comes after them at
// the same place.
// Based on: [GBP07]: the temporal weight, lifespans, replacement at the same place, extrapolated
// temporal gradients.
#pragma once

#include "cache/ageing.h"
#include "cache/placed_records.h"

namespace sheen {

/// By how much of itself a record's light changes from its first frame to the next, |tau - 1|: of
/// irradiance, and of coefficients by the root of their squares, whichever is more. 0 where nothing
/// that it sees moves. Infinite where black becomes something.
float changeOf(const GatheredRecord& found);

/// For so many frames a record is used, its first among them: as long as its temporal weight,
/// 1 / (change (t - t_0)), is above 1 / a_t; at least 1 and at most the longest. [GBP07]
int lifespanOf(const GatheredRecord& found, const TemporalParams& params);

/// Begins the lives of records of a field from `first` on, which were gathered in this frame. Those
/// of the first frame of all end at different times, told by their places, so that what they bring
/// anew is spread over frames.
void beginLives(RecordField& field, size_t first, const TemporalParams& params, bool spread);

/// A frame later: what a record says has changed as foreseen, and it is older.
void growOlder(GatheredRecord& found, const TemporalParams& params);

/// Of records that were taken for a view, gathers anew those whose life has ended, those whose
/// light has changed by more than a_t as their witnesses say, whether that was foreseen or not, and
/// those on surfaces that moved: at their places or, of these, at their receivers. Returns how
/// many.
size_t renew(const Scene& scene, const Receivers& receivers, const PlacementParams& placement,
             const Ageing& ageing, Gatherer& gatherer, RecordField& field);

}  // namespace sheen
