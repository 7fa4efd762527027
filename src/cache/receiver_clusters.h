// Receivers parted into clusters that are likely to receive similar light, by geometry alone.
// Based on: [WWZ09, 3.2].
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "receivers/receivers.h"

namespace sheen {

struct ClusterParams {
    int count = 1000;         ///< of clusters, about
    float alpha = 0.3f;       ///< what distance counts against the angle between normals
    int most_iterations = 8;  ///< of k-means
};

/// What is likely to change light from place to place: alpha |x - x_k| + sqrt(2 - 2 n.n_k)
/// [WWZ09, eq. 2], lengths over the median distance of the receivers from the viewer. So neither
/// the scene's scale nor far surroundings change clusters.
class ClusterMetric {
  public:
    ClusterMetric(const Receivers& receivers, float alpha);

    /// Between two points; normals are unit.
    float error(const vec3& x, const vec3& n, const vec3& x_k, const vec3& n_k) const {
        return scale_ * glm::length(x - x_k) + glm::length(n - n_k);
    }
    /// alpha over the unit of length.
    float scale() const { return scale_; }

  private:
    float scale_;
};

/// Members of one order, and the site for all of them.
struct ReceiverCluster {
    vec3 position{};                ///< where k-means ended: about the members' mean
    vec3 normal{};                  ///< likewise, unit
    size_t site = 0;                ///< the member of the smallest error, a receiver
    std::vector<uint32_t> members;  ///< receivers, in order
};

/// Clusters of those of the receivers, each with a surface, and none without members. Where k-means
/// begins is told by geometric variation: down a quadtree of the image each quarter gets its share
/// of the clusters by the sum of its receivers' errors against their own mean, and where one is
/// left, one of them by chance is a first centre.
std::vector<ReceiverCluster> clusterReceivers(const Receivers& receivers,
                                              std::span<const uint32_t> of,
                                              const ClusterParams& params);

}  // namespace sheen
