#include "cache/kmeans.h"

#include <algorithm>
#include <utility>

#include "cache/receiver_clusters.h"
#include "cache/scan.h"
#include "rays/jitter.h"

namespace sheen {
namespace {

// So many clusters of all that is seen: about a fifth of the records that a scan places.
float wantedClusters(const PlacementParams& params) {
    constexpr float kPerAccuracy = 200.0f;
    return params.clusters > 0 ? static_cast<float>(params.clusters)
                               : kPerAccuracy / params.accuracy;
}

// Its place in an order in which those that follow each other lie anywhere.
std::pair<uint32_t, size_t> shuffled(size_t receiver) {
    return {pcgHash(static_cast<uint32_t>(receiver)), receiver};
}

}  // namespace

KMeans::KMeans(const PlacedRecords& placed, bool quiet)
    : receivers_(placed.receivers()),
      params_(placed.params()),
      anew_(placed.field().records.empty()),
      quiet_(quiet) {
    std::vector<uint32_t> missed;
    size_t seen = 0;
    for (size_t i = 0; i < receivers_.positions.size(); ++i) {
        seen += receivers_.seen(i) ? 1 : 0;
        if (placed.coverage().missed(i)) {
            missed.push_back(static_cast<uint32_t>(i));
        }
    }
    if (missed.empty()) {
        return;
    }
    const float share = static_cast<float>(missed.size()) / static_cast<float>(seen);
    const ClusterParams wanted{.count =
                                   std::max(static_cast<int>(share * wantedClusters(params_)), 1)};
    for (const ReceiverCluster& cluster : clusterReceivers(receivers_, missed, wanted)) {
        sites_.push_back(cluster.site);
    }
    std::sort(sites_.begin(), sites_.end(),
              [](size_t a, size_t b) { return shuffled(a) < shuffled(b); });
    progress_ = std::make_unique<Progress>("placing records, of clusters",
                                           static_cast<int>(sites_.size()), quiet);
}

// All sites are known before any is gathered. Still they come in batches, spread over all that is
// seen: what hemispheres see is kept until all of a batch is seen, and a batch tells the next how
// far records reach and where to look closer, the first by looking twice.
std::vector<SiteChoice> KMeans::next(const PlacedRecords& placed) {
    if (at_ == sites_.size()) {
        if (!rest_) {
            progress_.reset();  // its line ends before the next begins
            rest_ = std::make_unique<Scan>(receivers_, params_, false, quiet_);
        }
        return rest_->next(placed);
    }
    std::vector<SiteChoice> choices;
    const bool first = anew_ && at_ == 0;
    const size_t end = std::min(at_ + static_cast<size_t>(params_.batch), sites_.size());
    for (; at_ < end; ++at_) {
        const size_t i = sites_[at_];
        const NearestRecords nearest = placed.nearestTo(receivers_.positions[i]);
        choices.push_back({.receiver = i,
                           .nearest = nearest,
                           .radius = placed.predictedRadius(i, nearest[0]),
                           .first = first});
    }
    progress_->advance(static_cast<int>(choices.size()));
    return choices;
}

}  // namespace sheen
