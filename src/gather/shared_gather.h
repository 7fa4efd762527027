// Gathering shared out over ranks: a site's record depends on the site alone, so that it does not
// matter who gathers it.
#pragma once

#include "core/ranks.h"
#include "gather/gatherer.h"

namespace sheen {

/// Of the first rank: has sites gathered by all. Records that live for some frames (lookAheadBy())
/// it does not know.
class SharedGatherer : public Gatherer {
  public:
    /// `own`: what this rank gathers its share by. Both must outlive it.
    SharedGatherer(Gatherer& own, const RankedJob& job) : own_(own), job_(job) {}

    std::vector<GatheredRecord> gather(std::span<const RecordSite> sites) override;

  private:
    Gatherer& own_;
    const RankedJob& job_;
};

/// On the others: gathers, by `own`, what a SharedGatherer asks for, until the first rank ends.
void serveGather(Gatherer& own, const RankedJob& job);

}  // namespace sheen
