#include "cache/receiver_clusters.h"

#include <algorithm>
#include <array>
#include <bit>
#include <limits>
#include <map>
#include <nanoflann.hpp>
#include <utility>

#include "core/parallel.h"
#include "rays/jitter.h"

namespace sheen {
namespace {

// Iterations end where fewer of the receivers than this change their cluster.
constexpr float kSettled = 0.002f;

using Members = std::vector<uint32_t>;  // receivers, in order

// Half of the receivers are seen from nearer than this.
float medianDistance(const Receivers& receivers) {
    std::vector<float> distances;
    for (size_t i = 0; i < receivers.positions.size(); ++i) {
        if (receivers.seen(i)) {
            distances.push_back(glm::length(receivers.positions[i] - receivers.viewer(i)));
        }
    }
    if (distances.empty()) {
        return 1.0f;
    }
    const auto middle = distances.begin() + static_cast<ptrdiff_t>(distances.size() / 2);
    std::nth_element(distances.begin(), middle, distances.end());
    return *middle;
}

struct Center {
    vec3 position{};
    vec3 normal{};
};

struct Clustering {
    const Receivers& receivers;
    ClusterMetric metric;

    Center at(uint32_t i) const { return {receivers.positions[i], receivers.normals[i]}; }
    float error(uint32_t i, const Center& c) const {
        return metric.error(receivers.positions[i], receivers.normals[i], c.position, c.normal);
    }
    // Of members, of which there must be some.
    Center mean(std::span<const uint32_t> members) const {
        dvec3 position(0.0), normal(0.0);
        for (const uint32_t i : members) {
            position += dvec3(receivers.positions[i]);
            normal += dvec3(receivers.normals[i]);
        }
        const double length = glm::length(normal);
        return {
            .position = vec3(position / static_cast<double>(members.size())),
            .normal = length > 0.0 ? vec3(normal / length) : receivers.normals[members.front()]};
    }
    double variation(std::span<const uint32_t> members) const {
        if (members.empty()) {
            return 0.0;
        }
        const Center center = mean(members);
        double sum = 0.0;
        for (const uint32_t i : members) {
            sum += error(i, center);
        }
        return sum;
    }
};

// Shares `count` out in proportion to variation (Webster's method), to each part as many as it has
// members at most; where nothing varies, by members.
std::vector<int> shareOut(const Clustering& clustering, std::span<const Members> parts, int count) {
    constexpr double kByMembers = 1e-6;
    std::vector<double> weights;
    for (const Members& members : parts) {
        weights.push_back(clustering.variation(members) +
                          kByMembers * static_cast<double>(members.size()));
    }
    std::vector<int> shares(parts.size());
    for (int given = 0; given < count; ++given) {
        size_t next = parts.size();
        double most = 0.0;
        for (size_t k = 0; k < parts.size(); ++k) {
            const double claim = weights[k] / (2 * shares[k] + 1);
            if (shares[k] < static_cast<int>(parts[k].size()) && claim > most) {
                most = claim;
                next = k;
            }
        }
        if (next == parts.size()) {
            break;
        }
        ++shares[next];
    }
    return shares;
}

// A square of the image and the members in it.
struct Quad {
    int x, y, size;
    Members members;
};

std::vector<Quad> quartersOf(const Quad& quad, int image_width) {
    const int half = quad.size / 2;
    std::vector<Quad> quarters;
    for (const int k : {0, 1, 2, 3}) {
        quarters.push_back({quad.x + (k % 2) * half, quad.y + (k / 2) * half, half, {}});
    }
    for (const uint32_t i : quad.members) {
        const bool right = static_cast<int>(i) % image_width >= quad.x + half;
        const bool below = static_cast<int>(i) / image_width >= quad.y + half;
        quarters[(right ? 1u : 0u) + (below ? 2u : 0u)].members.push_back(i);
    }
    return quarters;
}

// Adds so many first centres in a quad.
void seed(const Clustering& clustering, const Quad& quad, int count, std::vector<Center>& centers) {
    if (count >= static_cast<int>(quad.members.size())) {
        std::transform(quad.members.begin(), quad.members.end(), std::back_inserter(centers),
                       [&](uint32_t i) { return clustering.at(i); });
        return;
    }
    const int width = clustering.receivers.image.width;
    if (count == 1) {
        const auto corner = static_cast<uint32_t>(quad.y * width + quad.x);
        const float u = randomPlace(corner, static_cast<uint32_t>(quad.size)).x;
        const float of = u * static_cast<float>(quad.members.size());
        centers.push_back(clustering.at(quad.members[static_cast<size_t>(of)]));
    }
    if (count <= 1) {
        return;
    }
    const std::vector<Quad> quarters = quartersOf(quad, width);
    std::array<Members, 4> parts;
    for (size_t k = 0; k < parts.size(); ++k) {
        parts[k] = quarters[k].members;
    }
    const std::vector<int> shares = shareOut(clustering, parts, count);
    for (size_t k = 0; k < parts.size(); ++k) {
        seed(clustering, quarters[k], shares[k], centers);
    }
}

// Centres, as nanoflann asks for points: the length of a difference of position, scaled, and normal
// as one vector is at most their error and at least that over the root of 2.
class CenterTree {
  public:
    CenterTree(const Clustering& clustering, std::span<const Center> centers)
        : clustering_(clustering), centers_(centers), tree_(kDimensions, *this) {}

    // Of a receiver, which is nearest to `before` as far as is known; the first of several.
    size_t nearest(uint32_t i, size_t before) const {
        Nearest result{*this, i, before, clustering_.error(i, centers_[before])};
        std::array<float, kDimensions> at;
        for (size_t axis = 0; axis < kDimensions; ++axis) {
            at[axis] = coordinate(clustering_.at(i), axis);
        }
        tree_.findNeighbors(result, at.data(), {});
        return result.center;
    }

    size_t kdtree_get_point_count() const { return centers_.size(); }
    float kdtree_get_pt(size_t k, size_t axis) const { return coordinate(centers_[k], axis); }
    template <class Box>
    bool kdtree_get_bbox(Box&) const {
        return false;
    }

  private:
    static constexpr size_t kDimensions = 6;

    // Keeps the nearest by the metric.
    struct Nearest {
        const CenterTree& tree;
        uint32_t receiver;
        size_t center;
        float error;

        bool full() const { return true; }
        size_t size() const { return 1; }
        // Rounding must hide none that is as near.
        float worstDist() const { return error * error * 1.0001f + 1e-12f; }
        bool addPoint(float, size_t k) {
            const float other = tree.clustering_.error(receiver, tree.centers_[k]);
            if (other < error || (other == error && k < center)) {
                error = other;
                center = k;
            }
            return true;
        }
    };

    // Positions from a centre on: their differences are exact however far from the origin they are.
    float coordinate(const Center& c, size_t axis) const {
        const auto k = static_cast<glm::length_t>(axis % 3);
        return axis < 3
                   ? clustering_.metric.scale() * (c.position[k] - centers_.front().position[k])
                   : c.normal[k];
    }

    const Clustering& clustering_;
    const std::span<const Center> centers_;
    const nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<float, CenterTree>,
                                              CenterTree, static_cast<int>(kDimensions), size_t>
        tree_;
};

// Gives each member its nearest centre: `of` [member]. How many of them changed.
int classify(const Clustering& clustering, std::span<const uint32_t> members,
             std::span<const Center> centers, std::vector<size_t>& of) {
    const CenterTree tree(clustering, centers);
    std::vector<uint8_t> changed(members.size());
    parallelFor(
        static_cast<int>(members.size()),
        [&](int k) {
            const auto m = static_cast<size_t>(k);
            const size_t nearest = tree.nearest(members[m], of[m]);
            changed[m] = nearest != of[m] ? 1 : 0;
            of[m] = nearest;
        },
        64);
    return static_cast<int>(std::count(changed.begin(), changed.end(), 1));
}

std::vector<Members> partsOf(std::span<const uint32_t> members, std::span<const size_t> of,
                             size_t clusters) {
    std::vector<Members> parts(clusters);
    for (size_t m = 0; m < members.size(); ++m) {
        parts[of[m]].push_back(members[m]);
    }
    return parts;
}

// Lloyd's iterations, until hardly any member changes. [center] its members.
std::vector<Members> settle(const Clustering& clustering, std::span<const uint32_t> members,
                            int most_iterations, std::vector<Center>& centers) {
    std::vector<size_t> of(members.size(), 0);
    for (int iteration = 0;; ++iteration) {
        const int changed = classify(clustering, members, centers, of);
        std::vector<Members> parts = partsOf(members, of, centers.size());
        if (iteration == most_iterations ||
            static_cast<float>(changed) <= kSettled * static_cast<float>(members.size())) {
            return parts;
        }
        for (size_t k = 0; k < centers.size(); ++k) {
            if (!parts[k].empty()) {
                centers[k] = clustering.mean(parts[k]);
            }
        }
    }
}

ReceiverCluster clusterAt(const Clustering& clustering, const Center& center, Members members) {
    const uint32_t site =
        *std::min_element(members.begin(), members.end(), [&](uint32_t a, uint32_t b) {
            return clustering.error(a, center) < clustering.error(b, center);
        });
    return {.position = center.position,
            .normal = center.normal,
            .site = site,
            .members = std::move(members)};
}

}  // namespace

ClusterMetric::ClusterMetric(const Receivers& receivers, float alpha)
    : scale_(alpha / std::max(medianDistance(receivers), std::numeric_limits<float>::min())) {}

std::vector<ReceiverCluster> clusterReceivers(const Receivers& receivers,
                                              std::span<const uint32_t> of,
                                              const ClusterParams& params) {
    const Clustering clustering{receivers, ClusterMetric(receivers, params.alpha)};
    // A record serves its own order and those that ask for less.
    std::map<int8_t, Members> by_order;
    for (const uint32_t i : of) {
        by_order[receivers.orders[i]].push_back(i);
    }
    std::vector<Members> groups;
    for (auto& [order, members] : by_order) {
        groups.push_back(std::move(members));
    }
    const std::vector<int> shares = shareOut(clustering, groups, params.count);
    const auto longer =
        static_cast<uint32_t>(std::max(receivers.image.width, receivers.image.height));
    std::vector<ReceiverCluster> clusters;
    for (size_t g = 0; g < groups.size(); ++g) {
        const Quad image{0, 0, static_cast<int>(std::bit_ceil(longer)), std::move(groups[g])};
        std::vector<Center> centers;
        seed(clustering, image, std::max(shares[g], 1), centers);
        std::vector<Members> parts =
            settle(clustering, image.members, params.most_iterations, centers);
        for (size_t k = 0; k < centers.size(); ++k) {
            if (!parts[k].empty()) {
                clusters.push_back(clusterAt(clustering, centers[k], std::move(parts[k])));
            }
        }
    }
    return clusters;
}

}  // namespace sheen
