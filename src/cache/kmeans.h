// Choosing sites before anything is gathered: receivers are parted into clusters that are likely to
// receive similar light, by geometry alone, and each cluster has one record.
// Based on: [WWZ+09, 3.2].
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <vector>

#include "cache/fill.h"
#include "core/progress.h"

namespace sheen {

struct ClusterParams {
    int count = 1000;         ///< of clusters, about; never more than receivers
    float alpha = 0.3f;       ///< what the way to a cluster's centre counts against normals
    int most_iterations = 8;  ///< of k-means
};

struct ClusterCenter {
    vec3 position{};          ///< mean of the members'
    vec3 normal{};            ///< likewise, unit
    int order = 0;            ///< that all members are of (Receivers::orders)
    float largest_error = 0;  ///< of a member
};

struct Clusters {
    static constexpr int kNone = -1;
    std::vector<ClusterCenter> centers;
    std::vector<size_t> sites;  ///< [center] the member of the smallest error, a receiver
    std::vector<int> of;        ///< [receiver] center; kNone: no surface
};

/// The error of a receiver in a cluster is alpha |x - x_k| + sqrt(2 - 2 n.n_k) [WWZ+09, eq. 2],
/// lengths over the receivers' median distance from the viewer: that changes with nothing that the
/// scene's scale or far surroundings change. First centres: down a quadtree of the image each
/// quarter gets its share of them by the sum of its receivers' errors against their own mean; then
/// k-means. `previous`: of a former frame. Its centres stay as they are and take whom they reach
/// with no larger error than they had; the rest is clustered anew, into what is left of the number.
Clusters clusterReceivers(const Receivers& receivers, const ClusterParams& params,
                          std::span<const ClusterCenter> previous = {});

/// So many clusters at an accuracy: as the scan's records (docs/decisions/placement.md), and at
/// most one for four receivers.
int clusterCount(const Receivers& receivers, float accuracy);

/// First all clusters' sites, of which none knows what the others find; then what their records
/// leave is scanned.
class KMeans : public SiteChooser {
  public:
    /// `quiet`: no progress is printed.
    KMeans(const Receivers& receivers, const PlacementParams& params, bool quiet);

    std::vector<SiteChoice> next(const PlacedRecords& placed) override;

    size_t clusterSites() const { return clusters_.sites.size(); }

  private:
    const Receivers& receivers_;
    const PlacementParams& params_;
    const bool quiet_;
    const Clusters clusters_;
    std::vector<float> radii_;  // [center] that reach its farthest member
    size_t at_ = 0;
    std::unique_ptr<Progress> progress_;
    std::unique_ptr<SiteChooser> rest_;
};

}  // namespace sheen
