// Records that live for some frames: how long, what they say meanwhile, and who comes after them at
// the same place.
// Based on: [GBP07]: the temporal weight, lifespans, replacement at the same place, temporal
// gradients, extrapolated and interpolated.
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

/// Of a record whose temporal gradient is interpolated: its light at both ends.
struct Life {
    GatheredRecord first;                ///< as it was gathered
    std::optional<GatheredRecord> next;  ///< what took its place; none: it goes on, or ended unseen
    int frames = 0;                      ///< from one to the other
    bool jumps = false;  ///< light came or went suddenly, in the last of them (endLife())
};

/// Ends the life of a record that `next` takes the place of. `change`: of its light since it was
/// gathered, over itself, as its witnesses say. The frame before it was below a_t: where it is
/// several times that now, and what was gathered agrees, light has jumped, and a line would tell of
/// it before it came.
void endLife(const GatheredRecord& found, const GatheredRecord& next, float change,
             const TemporalParams& params);

/// The record at an age: on the line between both ends in all that it says, gradients and reach
/// among them. As it was gathered where nothing took its place, and where light jumps. [GBP07]
GatheredRecord recordAt(const Life& life, int age);

/// Begins the lives of records of a field from `first` on, which were gathered in this frame. Those
/// of the first frame of all end at different times, told by their places, so that what they bring
/// anew is spread over frames; where gradients are interpolated, none before half of the longest
/// life.
void beginLives(RecordField& field, size_t first, const TemporalParams& params, bool spread);

/// A frame later: what a record says has changed as foreseen, and it is older.
void growOlder(GatheredRecord& found, const TemporalParams& params);

/// Of records that were taken for a view, gathers anew those whose life has ended, those whose
/// light has changed by more than a_t as their witnesses say, whether that was foreseen or not, and
/// those on surfaces that moved: at their places or, of these, at their receivers. Records that
/// have no lives but strata are followed instead (Gatherer::follow()); of these, those without
/// strata are gathered anew in every frame in which more than cameras moves. Returns how many were
/// gathered.
size_t renew(const Scene& scene, const Receivers& receivers, const PlacementParams& placement,
             const Ageing& ageing, Gatherer& gatherer, RecordField& field);

}  // namespace sheen
