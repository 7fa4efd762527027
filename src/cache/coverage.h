// Which receivers are served, by the records placed so far.
#pragma once

#include <cstdint>
#include <vector>

#include "cache/reach.h"
#include "receivers/receivers.h"

namespace sheen {

class Coverage {
  public:
    /// `weight`: by which records are placed. All must outlive it.
    Coverage(const Receivers& receivers, const ReachBounds& bounds, const WeightParams& weight);

    void add(const Record& record) { splat(record, true); }
    /// One that was added, as it was then.
    void remove(const Record& record) { splat(record, false); }

    /// Whether receiver i has a surface and no record serves it.
    bool uncovered(size_t i) const;
    /// Likewise, unless it was given up.
    bool missed(size_t i) const { return uncovered(i) && given_up_[i] == 0; }
    /// For a receiver that not even a record of its own serves, where numbers are not sound: else
    /// whoever looks for what is missed would come back for ever.
    void giveUpIfMissed(size_t i) { given_up_[i] = missed(i) ? 1 : 0; }
    int countUncovered() const;

  private:
    void splat(const Record& record, bool add);

    const Receivers& receivers_;
    const ReachBounds& bounds_;
    const WeightParams weight_;
    std::vector<uint32_t> sums_;  // of weights
    std::vector<uint8_t> given_up_;
};

}  // namespace sheen
