// Clusters of receivers, and placement that begins with them.
#include <numeric>
#include <set>

#include "cache/receiver_clusters.h"
#include "core/parallel.h"
#include "test_placement.h"

namespace sheen {
namespace {

std::vector<uint32_t> allSeen(const Receivers& receivers) {
    std::vector<uint32_t> seen;
    for (uint32_t i = 0; i < receivers.positions.size(); ++i) {
        if (receivers.seen(i)) {
            seen.push_back(i);
        }
    }
    return seen;
}

std::vector<ReceiverCluster> clustersOf(const Stage& stage, const ClusterParams& params) {
    return clusterReceivers(stage.receivers, allSeen(stage.receivers), params);
}

// Each receiver's cluster.
std::vector<int> ownersOf(const Stage& stage, const std::vector<ReceiverCluster>& clusters) {
    std::vector<int> owner(stage.receivers.positions.size(), -1);
    for (size_t k = 0; k < clusters.size(); ++k) {
        for (const uint32_t i : clusters[k].members) {
            EXPECT_EQ(owner[i], -1) << "receiver " << i;
            owner[i] = static_cast<int>(k);
        }
    }
    return owner;
}

// Tilts the normals of the right half to and fro.
void tiltRightHalf(Stage& stage) {
    Receivers& r = stage.receivers;
    for (const uint32_t i : allSeen(r)) {
        if (i % kWidth >= kWidth / 2) {
            r.normals[i] =
                glm::normalize(vec3(0.6f * std::sin(1.3f * static_cast<float>(i)), 1, 0));
        }
    }
}

Stage movedBy(Stage stage, const vec3& way) {
    for (vec3& p : stage.receivers.positions) {
        p += way;
    }
    stage.receivers.image.view.origin += way;
    return stage;
}

TEST(ClusterMetric, IsTheFormulaOfThePaper) {
    const Stage stage = makeStage(0, 0);
    const ClusterMetric metric(stage.receivers, 0.3f);
    const vec3 x(1, 2, 3), up(0, 1, 0);
    EXPECT_EQ(metric.error(x, up, x, up), 0.0f);
    const vec3 d(0.2f, -0.1f, 0.4f);
    EXPECT_FLOAT_EQ(metric.error(x + d, up, x, up), metric.scale() * glm::length(d));
    for (const float angle : {0.1f, 1.0f, 3.0f}) {
        const vec3 n(std::sin(angle), std::cos(angle), 0);
        EXPECT_NEAR(metric.error(x, n, x, up), std::sqrt(2.0f - 2.0f * glm::dot(n, up)), 1e-5f);
        EXPECT_NEAR(metric.error(x + d, n, x, up),
                    metric.error(x + d, up, x, up) + metric.error(x, n, x, up), 1e-6f);
    }
}

TEST(ClusterMetric, CountsLengthsInMedianDistances) {
    const Stage stage = makeStage(0, 0);
    const Receivers& r = stage.receivers;
    std::vector<float> distances;
    for (const uint32_t i : allSeen(r)) {
        distances.push_back(glm::length(r.positions[i] - r.image.view.origin));
    }
    std::sort(distances.begin(), distances.end());
    const float median = distances[distances.size() / 2];
    EXPECT_FLOAT_EQ(ClusterMetric(r, 0.3f).scale(), 0.3f / median);
    // However far a few are, nothing changes.
    Stage far = stage;
    far.receivers.positions[allSeen(r).front()] *= 1e6f;
    EXPECT_NEAR(ClusterMetric(far.receivers, 0.3f).scale(), 0.3f / median, 0.01f / median);
}

TEST(Clusters, PartReceiversEachToItsNearestCentre) {
    Stage stage = makeStage(0, 4);
    tiltRightHalf(stage);
    const ClusterParams params{.count = 60};
    const std::vector<ReceiverCluster> clusters = clustersOf(stage, params);
    EXPECT_LE(clusters.size(), 60u);
    EXPECT_GE(clusters.size(), 50u);
    const Receivers& r = stage.receivers;
    const ClusterMetric metric(r, params.alpha);
    const std::vector<int> owner = ownersOf(stage, clusters);
    for (const uint32_t i : allSeen(r)) {
        ASSERT_GE(owner[i], 0);
        const ReceiverCluster& own = clusters[static_cast<size_t>(owner[i])];
        const auto error = [&](const ReceiverCluster& c, size_t member) {
            return metric.error(r.positions[member], r.normals[member], c.position, c.normal);
        };
        ASSERT_LE(error(own, own.site), error(own, i));
        for (const ReceiverCluster& other : clusters) {
            if (r.orders[other.site] == r.orders[i]) {
                ASSERT_LE(error(own, i), error(other, i));
            }
        }
        ASSERT_EQ(r.orders[own.site], r.orders[i]);
        ASSERT_EQ(owner[own.site], owner[i]);
    }
}

TEST(Clusters, AreDenseWhereGeometryVaries) {
    Stage stage = makeStage(0, 0);
    tiltRightHalf(stage);
    const std::vector<ReceiverCluster> clusters = clustersOf(stage, {.count = 100});
    const auto right = std::count_if(clusters.begin(), clusters.end(),
                                     [](const auto& c) { return c.site % kWidth >= kWidth / 2; });
    EXPECT_GT(2 * right, 3 * (static_cast<long>(clusters.size()) - right));
}

TEST(Clusters, TheSameWhateverTheThreads) {
    Stage stage = makeStage(0, 3);
    tiltRightHalf(stage);
    setThreadCount(1);
    const std::vector<int> one = ownersOf(stage, clustersOf(stage, {.count = 80}));
    setThreadCount(4);
    const std::vector<int> four = ownersOf(stage, clustersOf(stage, {.count = 80}));
    setThreadCount(0);
    EXPECT_EQ(one, four);
}

TEST(Clusters, OfFewReceivers) {
    const Stage stage = makeStage(0, 0);
    EXPECT_TRUE(clusterReceivers(stage.receivers, {}, {.count = 10}).empty());
    EXPECT_TRUE(clusterReceivers(Receivers(), {}, {}).empty());
    const std::vector<uint32_t> seen = allSeen(stage.receivers);
    const uint32_t one = seen[seen.size() / 2];
    const std::vector<ReceiverCluster> single =
        clusterReceivers(stage.receivers, std::array{one}, {.count = 10});
    ASSERT_EQ(single.size(), 1u);
    EXPECT_EQ(single[0].site, one);
    EXPECT_EQ(single[0].members, std::vector{one});
    const std::vector<uint32_t> few(seen.begin(), seen.begin() + 7);
    EXPECT_EQ(clusterReceivers(stage.receivers, few, {.count = 100}).size(), 7u);
    EXPECT_EQ(clusterReceivers(stage.receivers, few, {.count = 0}).size(), 1u);
}

TEST(Clusters, OfReceiversAllAtOnePlace) {
    Stage stage = makeStage(0, 0);
    stage.receivers.positions.assign(kWidth * kHeight, vec3(0, 0, -1));
    const std::vector<int> owner = ownersOf(stage, clustersOf(stage, {.count = 50}));
    for (const uint32_t i : allSeen(stage.receivers)) {
        EXPECT_GE(owner[i], 0);
    }
    stage.receivers.positions.assign(kWidth * kHeight, stage.receivers.image.view.origin);
    EXPECT_GE(clustersOf(stage, {.count = 50}).size(), 1u);
}

TEST(Clusters, ChangeWithNeitherScaleNorOrigin) {
    Stage stage = makeStage(0, 0);
    tiltRightHalf(stage);
    const std::vector<int> owner = ownersOf(stage, clustersOf(stage, {.count = 80}));
    // By powers of two all is exact.
    for (const float scale : {1.0f / 1024.0f, 1024.0f}) {
        Stage other = makeStage(0, 0, scale);
        tiltRightHalf(other);
        EXPECT_EQ(ownersOf(other, clustersOf(other, {.count = 80})), owner) << scale;
    }
    // Otherwise receivers that lie between clusters may change sides, and what follows from that.
    const auto errorOf = [](const Stage& s) {
        const ClusterMetric metric(s.receivers, 0.3f);
        double sum = 0.0;
        for (const ReceiverCluster& c : clustersOf(s, {.count = 80})) {
            for (const uint32_t i : c.members) {
                sum += metric.error(s.receivers.positions[i], s.receivers.normals[i], c.position,
                                    c.normal);
            }
        }
        return sum;
    };
    const double error = errorOf(stage);
    Stage thousand = makeStage(0, 0, 1000.0f);
    tiltRightHalf(thousand);
    EXPECT_NEAR(errorOf(thousand), error, 0.02 * error);
    EXPECT_NEAR(errorOf(movedBy(stage, vec3(3e4f, -2e4f, 1e4f))), error, 0.02 * error);
}

PlacementParams byKMeans() {
    PlacementParams params;
    params.sites = SitesBy::kKMeans;
    return params;
}

TEST(PlacementByKMeans, CoversEveryPixelHoweverManyClusters) {
    const Stage stage = makeStage(0, 4);
    for (const int clusters : {0, 1, 30, 1000, 100000}) {
        PlacementParams params = byKMeans();
        params.clusters = clusters;
        RecordField field;
        SCOPED_TRACE(clusters);
        expectCovered(stage, params, place(stage, params, kNoChange, &field));
        EXPECT_GE(field.of_clusters, 1u);
        EXPECT_LE(field.of_clusters, field.records.size());
    }
}

TEST(PlacementByKMeans, TheSameBitsWhateverTheThreads) {
    const Stage stage = makeStage(0, 4);
    setThreadCount(1);
    const Placement one = place(stage, byKMeans());
    setThreadCount(4);
    const Placement four = place(stage, byKMeans());
    setThreadCount(0);
    expectSame(one, four);
}

TEST(PlacementByKMeans, NothingSeenNothingPlaced) {
    Stage stage = makeStage(0, 0);
    stage.receivers.footprints.assign(kWidth * kHeight, 0.0f);
    stage.receivers.orders.assign(kWidth * kHeight, kNoOrder);
    EXPECT_TRUE(place(stage, byKMeans()).cache.records.empty());
    Stage empty;
    EXPECT_TRUE(place(empty, byKMeans()).cache.records.empty());
}

TEST(PlacementByKMeans, APixelThatNothingServesIsCounted) {
    Stage stage = makeStage(0, 0);
    constexpr int kPixel = kWidth * (kHeight - 1) + kWidth / 2;
    stage.receivers.positions[kPixel] = vec3(std::nanf(""));
    EXPECT_EQ(place(stage, byKMeans()).uncovered, 1);
}

// So records that are kept from frame to frame are centres that stay.
TEST(PlacementByKMeans, WhatRecordsServeAlreadyIsNotClusteredAgain) {
    const Stage stage = makeStage(0, 0);
    RecordField field;
    place(stage, byKMeans(), kNoChange, &field);
    const size_t records = field.records.size(), clusters = field.of_clusters;
    place(stage, byKMeans(), kNoChange, &field);
    EXPECT_EQ(field.records.size(), records);
    EXPECT_EQ(field.of_clusters, clusters);
    PlacementParams finer = byKMeans();
    finer.max_pixels = 3.0f;
    place(stage, finer, kNoChange, &field);
    EXPECT_GT(field.of_clusters, clusters);
}

}  // namespace
}  // namespace sheen
