#include "cache/kmeans.h"

#include <algorithm>
#include <cmath>

#include "cache/receiver_clusters.h"
#include "cache/scan.h"

namespace sheen {
namespace {

// What hemispheres see is kept until all of a batch is seen, so all at once would take memory in
// proportion to their number.
constexpr size_t kBatch = 256;

// So many clusters of all that is seen, by the accuracy.
float clusterCount(const PlacementParams& params) {
    constexpr float kUsual = 1000.0f, kUsualAccuracy = 0.4f, kPower = 1.3f;
    return params.clusters > 0 ? static_cast<float>(params.clusters)
                               : kUsual * std::pow(kUsualAccuracy / params.accuracy, kPower);
}

float radiusOf(const ReceiverCluster& cluster, const Receivers& receivers,
               const PlacementParams& params) {
    float reach = params.min_pixels * receivers.footprints[cluster.site];
    for (const uint32_t i : cluster.members) {
        reach = std::max(
            reach, glm::length(receivers.positions[i] - receivers.positions[cluster.site]));
    }
    return reach / params.accuracy;
}

}  // namespace

KMeans::KMeans(const PlacedRecords& placed, bool quiet)
    : receivers_(placed.receivers()), params_(placed.params()), quiet_(quiet) {
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
    const ClusterParams wanted{
        .count = std::max(static_cast<int>(share * clusterCount(params_)), 1)};
    for (const ReceiverCluster& cluster : clusterReceivers(receivers_, missed, wanted)) {
        sites_.push_back({cluster.site, radiusOf(cluster, receivers_, params_)});
    }
    progress_ = std::make_unique<Progress>("placing records, of clusters",
                                           static_cast<int>(sites_.size()), quiet);
}

std::vector<SiteChoice> KMeans::next(const PlacedRecords& placed) {
    if (at_ == sites_.size()) {
        if (!rest_) {
            progress_.reset();  // its line ends before the next begins
            rest_ = std::make_unique<Scan>(receivers_, params_, false, quiet_);
        }
        return rest_->next(placed);
    }
    std::vector<SiteChoice> choices;
    for (; at_ < sites_.size() && choices.size() < kBatch; ++at_) {
        choices.push_back({.receiver = sites_[at_].receiver, .radius = sites_[at_].radius});
        choices.back().nearest.fill(kNoRecord);
        if (getenv("KFIRST")) choices.back().first = true;
    }
    progress_->advance(static_cast<int>(choices.size()));
    return choices;
}

}  // namespace sheen
