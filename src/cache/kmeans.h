// Choosing sites before anything is gathered: one for each cluster of receivers.
// Based on: [WWZ09, 3.2].
#pragma once

#include <memory>
#include <vector>

#include "cache/fill.h"
#include "core/progress.h"

namespace sheen {

/// First one site for each cluster (receiver_clusters.h) of what no record serves yet, chosen
/// whatever the others find; then what their records leave is scanned.
class KMeans : public SiteChooser {
  public:
    /// `placed`: what was before; it must outlive this. `quiet`: no progress is printed.
    KMeans(const PlacedRecords& placed, bool quiet);

    std::vector<SiteChoice> next(const PlacedRecords& placed) override;

    size_t clusterCount() const { return sites_.size(); }

  private:
    const Receivers& receivers_;
    const PlacementParams& params_;
    const bool anew_;
    const bool quiet_;
    std::vector<size_t> sites_;  // receivers, one for each cluster
    size_t at_ = 0;
    std::unique_ptr<Progress> progress_;
    std::unique_ptr<SiteChooser> rest_;
};

}  // namespace sheen
