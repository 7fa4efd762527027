#include "cache/kmeans.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <nanoflann.hpp>

#include "cache/scan.h"
#include "core/parallel.h"
#include "rays/jitter.h"

namespace sheen {
namespace {

// Iterations end where fewer of the receivers than this change their cluster.
constexpr float kSettled = 0.002f;
// Sites gathered together, for the sake of memory alone.
constexpr size_t kTogether = 256;

using Members = std::vector<uint32_t>;  // receivers, in order

// The error metric. As the length of one vector of position and normal it would be smaller, by at
// most the root of 2: a kd-tree of such vectors finds all that may be nearest.
struct ClusterMetric {
    const Receivers& receivers;
    float scale;  // alpha over the unit of length

    using Place = std::array<float, 6>;
    static constexpr int kDimensions = 6;

    Place place(const vec3& x, const vec3& n) const {
        return {scale * x.x, scale * x.y, scale * x.z, n.x, n.y, n.z};
    }
    Place place(uint32_t i) const { return place(receivers.positions[i], receivers.normals[i]); }
    float error(uint32_t i, const ClusterCenter& c) const {
        return scale * glm::length(receivers.positions[i] - c.position) +
               glm::length(receivers.normals[i] - c.normal);
    }
};

// Half of the receivers are seen from nearer than this.
float medianDistance(const Receivers& receivers) {
    std::vector<float> distances;
    for (size_t i = 0; i < receivers.positions.size(); ++i) {
        if (receivers.orders[i] != kNoOrder) {
            distances.push_back(glm::length(receivers.positions[i] - receivers.viewer(i)));
        }
    }
    if (distances.empty()) {
        return 1.0f;
    }
    const auto middle = distances.begin() + static_cast<ptrdiff_t>(distances.size() / 2);
    std::nth_element(distances.begin(), middle, distances.end());
    return std::max(*middle, std::numeric_limits<float>::min());
}

// The mean of members, none of which may be missing; their errors are not looked at.
ClusterCenter meanOf(const Receivers& receivers, std::span<const uint32_t> members) {
    dvec3 position(0.0), normal(0.0);
    for (const uint32_t i : members) {
        position += dvec3(receivers.positions[i]);
        normal += dvec3(receivers.normals[i]);
    }
    const double length = glm::length(normal);
    return {.position = vec3(position / static_cast<double>(members.size())),
            .normal = length > 0.0 ? vec3(normal / length) : receivers.normals[members.front()],
            .order = receivers.orders[members.front()]};
}

// The geometric variation of what a quad holds: the sum of errors against its mean.
double variationOf(const ClusterMetric& metric, std::span<const uint32_t> members) {
    if (members.empty()) {
        return 0.0;
    }
    const ClusterCenter mean = meanOf(metric.receivers, members);
    double sum = 0.0;
    for (const uint32_t i : members) {
        sum += metric.error(i, mean);
    }
    return sum;
}

// Shares `count` out in proportion to variation, to each part as many as it has members at most
// [Sainte-Lague]; where nothing varies, by members.
std::vector<int> shareOut(const ClusterMetric& metric, std::span<const Members> parts, int count) {
    constexpr double kByMembers = 1e-6;
    std::vector<double> weights;
    for (const Members& members : parts) {
        weights.push_back(variationOf(metric, members) +
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

// The first centres in a quad, so many of them, by descent.
void seed(const ClusterMetric& metric, const Quad& quad, int count,
          std::vector<ClusterCenter>& centers) {
    const Receivers& receivers = metric.receivers;
    const auto begin_at = [&](uint32_t i) { centers.push_back(meanOf(receivers, std::array{i})); };
    if (count >= static_cast<int>(quad.members.size())) {
        std::for_each(quad.members.begin(), quad.members.end(), begin_at);
        return;
    }
    if (count <= 1) {
        if (count == 1) {
            const auto node = static_cast<uint32_t>(quad.y * receivers.image.width + quad.x);
            const float u = randomPlace(node, static_cast<uint32_t>(quad.size)).x;
            begin_at(
                quad.members[static_cast<size_t>(u * static_cast<float>(quad.members.size()))]);
        }
        return;
    }
    const int half = quad.size / 2;
    std::vector<Members> parts(4);
    for (const uint32_t i : quad.members) {
        const auto width = static_cast<uint32_t>(receivers.image.width);
        const bool right = static_cast<int>(i % width) >= quad.x + half;
        const bool below = static_cast<int>(i / width) >= quad.y + half;
        parts[(right ? 1u : 0u) + (below ? 2u : 0u)].push_back(i);
    }
    const std::vector<int> shares = shareOut(metric, parts, count);
    for (int k = 0; k < 4; ++k) {
        seed(metric,
             {.x = quad.x + (k % 2) * half,
              .y = quad.y + (k / 2) * half,
              .size = half,
              .members = std::move(parts[static_cast<size_t>(k)])},
             shares[static_cast<size_t>(k)], centers);
    }
}

// Centres of one order as nanoflann asks for points.
struct CenterCloud {
    std::vector<ClusterMetric::Place> places;

    size_t kdtree_get_point_count() const { return places.size(); }
    float kdtree_get_pt(size_t i, size_t axis) const { return places[i][axis]; }
    template <class Box>
    bool kdtree_get_bbox(Box&) const {
        return false;
    }
};
using CenterTree =
    nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<float, CenterCloud>,
                                        CenterCloud, ClusterMetric::kDimensions, size_t>;

// Keeps the nearest by the metric; the smaller number of two that are as near.
struct NearestCenter {
    const ClusterMetric& metric;
    std::span<const ClusterCenter> centers;
    uint32_t receiver;
    size_t nearest;
    float error;

    bool full() const { return true; }
    size_t size() const { return 1; }
    float worstDist() const { return error * error * 1.0001f + 1e-12f; }
    bool addPoint(float, size_t i) {
        const float other = metric.error(receiver, centers[i]);
        if (other < error || (other == error && i < nearest)) {
            error = other;
            nearest = i;
        }
        return true;
    }
};

// Of each member the nearest centre; `of` says which it was, kNone: none yet. How many changed.
int classify(const ClusterMetric& metric, std::span<const uint32_t> members,
             std::span<const ClusterCenter> centers, std::vector<int>& of) {
    CenterCloud cloud;
    for (const ClusterCenter& c : centers) {
        cloud.places.push_back(metric.place(c.position, c.normal));
    }
    const CenterTree tree(ClusterMetric::kDimensions, cloud);
    std::vector<uint8_t> changed(members.size());
    parallelFor(
        static_cast<int>(members.size()),
        [&](int k) {
            const uint32_t i = members[static_cast<size_t>(k)];
            const int before = of[i];
            NearestCenter best{
                .metric = metric,
                .centers = centers,
                .receiver = i,
                .nearest = before == Clusters::kNone ? centers.size() : static_cast<size_t>(before),
                .error = before == Clusters::kNone
                             ? std::sqrt(std::numeric_limits<float>::max()) * 0.5f
                             : metric.error(i, centers[static_cast<size_t>(before)])};
            const ClusterMetric::Place at = metric.place(i);
            tree.findNeighbors(best, at.data(), {});
            of[i] = static_cast<int>(best.nearest);
            changed[static_cast<size_t>(k)] = of[i] != before ? 1 : 0;
        },
        64);
    return static_cast<int>(std::count(changed.begin(), changed.end(), 1));
}

// Members by cluster.
std::vector<Members> membersOf(std::span<const uint32_t> members, const std::vector<int>& of,
                               size_t clusters) {
    std::vector<Members> result(clusters);
    for (const uint32_t i : members) {
        result[static_cast<size_t>(of[i])].push_back(i);
    }
    return result;
}

// Clusters of members of one order, with the centres that they settled at; `of` gets them by
// numbers from 0 on.
std::vector<ClusterCenter> kmeans(const ClusterMetric& metric, const Quad& image, int count,
                                  int most_iterations, std::vector<int>& of) {
    const Members& members = image.members;
    std::vector<ClusterCenter> centers;
    seed(metric, image, count, centers);
    for (int iteration = 0; !centers.empty(); ++iteration) {
        const int changed = classify(metric, members, centers, of);
        if (iteration == most_iterations ||
            static_cast<float>(changed) <= kSettled * static_cast<float>(members.size())) {
            break;
        }
        const std::vector<Members> parts = membersOf(members, of, centers.size());
        for (size_t k = 0; k < centers.size(); ++k) {
            if (!parts[k].empty()) {
                centers[k] = meanOf(metric.receivers, parts[k]);
            }
        }
    }
    return centers;
}

// Adds clusters that have members to the result, with their sites; `numbers`: of `centers`, in
// `of`, by whoever made them.
void addClusters(const ClusterMetric& metric, std::span<const uint32_t> members,
                 std::span<const ClusterCenter> centers, const std::vector<int>& of, bool fixed,
                 Clusters& result) {
    const std::vector<Members> parts = membersOf(members, of, centers.size());
    for (size_t k = 0; k < centers.size(); ++k) {
        if (parts[k].empty()) {
            continue;
        }
        ClusterCenter center = centers[k];
        float least = kInfinity, largest = 0.0f;
        size_t site = parts[k].front();
        for (const uint32_t i : parts[k]) {
            const float error = metric.error(i, center);
            largest = std::max(largest, error);
            if (error < least) {
                least = error;
                site = i;
            }
            result.of[i] = static_cast<int>(result.centers.size());
        }
        if (!fixed) {
            center.largest_error = largest;
        }
        result.centers.push_back(center);
        result.sites.push_back(site);
    }
}

// Takes out of `members` those that centres of a former frame reach, which become clusters.
void keepPrevious(const ClusterMetric& metric, std::span<const ClusterCenter> previous,
                  Members& members, Clusters& result) {
    std::vector<int> of(metric.receivers.positions.size(), Clusters::kNone);
    classify(metric, members, previous, of);
    Members kept, rest;
    for (const uint32_t i : members) {
        const ClusterCenter& c = previous[static_cast<size_t>(of[i])];
        (metric.error(i, c) <= c.largest_error ? kept : rest).push_back(i);
    }
    addClusters(metric, kept, previous, of, true, result);
    members = std::move(rest);
}

}  // namespace

Clusters clusterReceivers(const Receivers& receivers, const ClusterParams& params,
                          std::span<const ClusterCenter> previous) {
    const ClusterMetric metric{.receivers = receivers,
                               .scale = params.alpha / medianDistance(receivers)};
    Clusters result;
    result.of.assign(receivers.positions.size(), Clusters::kNone);
    // A record serves none of another order than its own or those that ask for less.
    std::map<int, Members> by_order;
    for (size_t i = 0; i < receivers.positions.size(); ++i) {
        if (receivers.orders[i] != kNoOrder) {
            by_order[receivers.orders[i]].push_back(static_cast<uint32_t>(i));
        }
    }
    std::vector<Members> groups;
    for (auto& [order, members] : by_order) {
        std::vector<ClusterCenter> former;
        std::copy_if(previous.begin(), previous.end(), std::back_inserter(former),
                     [&](const ClusterCenter& c) { return c.order == order; });
        if (!former.empty()) {
            keepPrevious(metric, former, members, result);
        }
        groups.push_back(std::move(members));
    }
    const int left = std::max(params.count - static_cast<int>(result.centers.size()), 0);
    std::vector<int> shares = shareOut(metric, groups, left);
    const int width = receivers.image.width, height = receivers.image.height;
    int size = 1;
    while (size < std::max(width, height)) {
        size *= 2;
    }
    std::vector<int> of(receivers.positions.size(), Clusters::kNone);
    for (size_t g = 0; g < groups.size(); ++g) {
        if (groups[g].empty()) {
            continue;
        }
        const Quad image{.x = 0, .y = 0, .size = size, .members = std::move(groups[g])};
        // However few there are to be, what is seen has one.
        const std::vector<ClusterCenter> centers =
            kmeans(metric, image, std::max(shares[g], 1), params.most_iterations, of);
        addClusters(metric, image.members, centers, of, false, result);
    }
    return result;
}

int clusterCount(const Receivers& receivers, float accuracy) {
    constexpr float kUsual = 1000.0f, kUsualAccuracy = 0.4f, kPower = 1.3f;
    const auto seen = std::count_if(receivers.orders.begin(), receivers.orders.end(),
                                    [](int8_t order) { return order != kNoOrder; });
    const float wanted = kUsual * std::pow(kUsualAccuracy / accuracy, kPower);
    return static_cast<int>(std::max(std::min(wanted, static_cast<float>(seen) / 4.0f), 1.0f));
}

KMeans::KMeans(const Receivers& receivers, const PlacementParams& params, bool quiet)
    : receivers_(receivers),
      params_(params),
      quiet_(quiet),
      clusters_(clusterReceivers(receivers, {.count = clusterCount(receivers, params.accuracy)})),
      radii_(clusters_.centers.size()) {
    for (size_t i = 0; i < clusters_.of.size(); ++i) {
        if (clusters_.of[i] != Clusters::kNone) {
            const auto k = static_cast<size_t>(clusters_.of[i]);
            const vec3& site = receivers.positions[clusters_.sites[k]];
            radii_[k] =
                std::max(radii_[k], glm::length(receivers.positions[i] - site) / params.accuracy);
        }
    }
    if (!clusters_.sites.empty()) {
        progress_ = std::make_unique<Progress>("placing records, of clusters",
                                               static_cast<int>(clusters_.sites.size()), quiet);
    }
}

std::vector<SiteChoice> KMeans::next(const PlacedRecords& placed) {
    if (at_ == clusters_.sites.size()) {
        if (!rest_) {
            progress_.reset();  // its line ends before the next begins
            rest_ = std::make_unique<Scan>(receivers_, params_, false, quiet_);
        }
        return rest_->next(placed);
    }
    std::vector<SiteChoice> choices;
    for (; at_ < clusters_.sites.size() && choices.size() < kTogether; ++at_) {
        const size_t i = clusters_.sites[at_];
        SiteChoice choice{.receiver = i, .radius = radii_[at_]};
        choice.nearest.fill(kNoRecord);
        choice.radius = std::max(choice.radius,
                                 params_.min_pixels * receivers_.footprints[i] / params_.accuracy);
        choices.push_back(choice);
    }
    progress_->advance(static_cast<int>(choices.size()));
    return choices;
}

}  // namespace sheen
