// Records as they were gathered: of a view, and over many views.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include "cache/ageing.h"
#include "cache/placement_params.h"
#include "gather/gatherer.h"

namespace sheen {

/// All that was gathered for a view. It outlives passes: how far its records reach, and so by how
/// much their gradients may change what they say, is each pass's own.
struct RecordField {
    std::vector<GatheredRecord> records;  ///< as gathered
    std::vector<int> pixels;              ///< that they lie at
    size_t reused = 0;       ///< so many, the first, were gathered for other views, near the pixels
    size_t of_clusters = 0;  ///< so many of the others were gathered for clusters (kmeans.h)
    int gather_size = 0;     ///< that they were gathered with, or more
};

/// So many records nearby tell a new one where to look closer.
constexpr size_t kNearestRecords = 3;
constexpr size_t kNoRecord = ~size_t{0};
/// The nearest first; kNoRecord where there are fewer.
using NearestRecords = std::array<size_t, kNearestRecords>;

/// Of all records of the field but `except`, looked at one by one: for a few points.
NearestRecords nearestOf(const RecordField& field, const vec3& p, size_t except = kNoRecord);

/// Tells a site where light changes, by what these found.
void addContrasts(const RecordField& field, const NearestRecords& nearest, RecordSite& site);

/// Records that outlive views. What a record found does not depend on who looks, except what its
/// own lobe sees beyond its coefficients: that counts only as long as it is looked at from where it
/// was gathered.
class KeptRecords {
  public:
    size_t size() const { return records_.size(); }
    const std::vector<GatheredRecord>& records() const { return records_; }
    int gatherSize() const { return gather_size_; }
    /// Those of the view that was put last, until another one takes or drops some.
    std::span<const GatheredRecord> latest() const { return std::span(records_).last(latest_); }

    /// Hands over those that lie at a receiver and are of its order, in the order that they were
    /// kept in; at most one a receiver, the first: closer together they would say the same. Others
    /// stay, and so do those that will have the least reach away from the receiver itself.
    RecordField take(const Receivers& receivers, const PlacementParams& params);
    /// Keeps a view's.
    void put(RecordField field);
    /// Drops those that views have not seen for longest, until so many are left at the most.
    void dropToLatest(size_t most);

    /// Begins a frame of a scene that moves. `older`: something but cameras is different from the
    /// frame before, so that records are a frame older (growOlder()).
    void beginFrame(Ageing ageing, bool older);
    /// Of the frame that was begun; null: none was, and records live for ever.
    const Ageing* ageing() const { return ageing_ ? &*ageing_ : nullptr; }
    /// Drops those whose life has ended, which no view has asked for.
    void forgetEnded();

  private:
    std::vector<GatheredRecord> records_;
    size_t latest_ = 0;  // so many, the last, are of the view that was put last
    int gather_size_ = 0;
    std::optional<Ageing> ageing_;
};

}  // namespace sheen
