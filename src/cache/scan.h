// Choosing sites by scanning the image: first on a coarse grid, then on finer ones, row by row.
// Based on: [GKB09, algorithm 5], which is the last grid, a site at a time.
#pragma once

#include <memory>
#include <vector>

#include "cache/fill.h"
#include "core/progress.h"

namespace sheen {

/// Sites are chosen PlacementParams::batch at a time, by predicted radii: the batch is part of the
/// parameters and not of the machine, so the records never depend on the number of threads.
class Scan : public SiteChooser {
  public:
    /// `anew`: there are no records yet. `quiet`: no progress is printed.
    Scan(const Receivers& receivers, const PlacementParams& params, bool anew, bool quiet);

    std::vector<SiteChoice> next(const PlacedRecords& placed) override;

  private:
    int nextOnGrid(int i) const;
    std::vector<SiteChoice> choose(const PlacedRecords& placed, int first) const;
    void beginGrid();

    const Receivers& receivers_;
    const PlacementParams& params_;
    const bool anew_;
    const bool quiet_;
    int stride_;
    int at_ = 0;      // receiver
    int passed_ = 0;  // the farthest on this grid
    bool placed_any_ = false;
    std::unique_ptr<Progress> progress_;
};

}  // namespace sheen
