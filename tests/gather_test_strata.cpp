// Records that are followed by what their rays met, against records gathered anew.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "gather/ray_gather.h"
#include "gather/strata.h"
#include "scene/animation.h"
#include "test_light.h"
#include "test_scenes.h"
#include "test_sites.h"

namespace sheen {
namespace {

constexpr HemisphereParams kHemicubeOf24 = {.kind = HemisphereKind::kHemicube, .size = 24};

std::vector<RecordSite> strataSites(int count, int order) {
    std::vector<RecordSite> sites = sitesInGlossyRoom(count);
    for (RecordSite& site : sites) {
        site.order = order;
    }
    return sites;
}

// Records of a scene, and what follows them.
struct Followed {
    Anchors anchors;
    std::vector<GatheredRecord> records;

    // Gathers them in a scene where triangles move as said.
    Followed(const Scene& scene, std::span<const RecordSite> sites,
             std::vector<uint8_t> moves = {}) {
        const LitScene lit(scene);
        anchors.beginFrame(scene, std::move(moves), {}, 0);
        RayGatherer gatherer(lit.light, kHemicubeOf24);
        gatherer.keepStrata(anchors);
        records = gatherer.gather(sites);
    }
    // To another frame of it. Rays cast.
    int64_t follow(const Scene& scene, std::vector<uint8_t> moves = {}) {
        const LitScene lit(scene);
        anchors.beginFrame(scene, std::move(moves), {}, 0);
        RayGatherer gatherer(lit.light, kHemicubeOf24);
        gatherer.keepStrata(anchors);
        std::vector<GatheredRecord*> all;
        for (GatheredRecord& record : records) {
            all.push_back(&record);
        }
        gatherer.follow(all, false);
        return gatherer.rays();
    }
};

std::vector<GatheredRecord> gatheredAnew(const Scene& scene, std::span<const RecordSite> sites) {
    const LitScene lit(scene);
    return RayGatherer(lit.light, kHemicubeOf24).gather(sites);
}

// The root of the mean square of differences of irradiance, over the mean.
double differenceOf(std::span<const GatheredRecord> a, std::span<const GatheredRecord> b) {
    double squares = 0.0, sum = 0.0;
    for (size_t i = 0; i < a.size(); ++i) {
        const vec3 d = a[i].record.irradiance - b[i].record.irradiance;
        squares += static_cast<double>(glm::dot(d, d)) / 3.0;
        sum += static_cast<double>(luminance(b[i].record.irradiance));
    }
    const auto count = static_cast<double>(a.size());
    return std::sqrt(squares / count) / (sum / count);
}

TEST(Strata, OfASceneThatStandsSayWhatTheyDid) {
    for (const int order : {shared::DIFFUSE_ORDER, 4}) {
        Followed followed(glossyRoom(), strataSites(12, order));
        const std::vector<GatheredRecord> before = followed.records;
        EXPECT_EQ(followed.follow(glossyRoom()), 0) << "no rays";
        for (size_t i = 0; i < before.size(); ++i) {
            EXPECT_EQ(followed.records[i].record.irradiance, before[i].record.irradiance);
            EXPECT_EQ(followed.records[i].record.radius, before[i].record.radius);
            EXPECT_EQ(followed.records[i].record.translation_g, before[i].record.translation_g);
            EXPECT_EQ(followed.records[i].sh, before[i].sh);
            EXPECT_EQ(followed.records[i].contrasts.size(), before[i].contrasts.size());
        }
    }
}

TEST(Strata, SayWhatTheRaysSaw) {
    const std::vector<RecordSite> sites = strataSites(24, shared::DIFFUSE_ORDER);
    const Followed followed(glossyRoom(), sites);
    // Anchors lie elsewhere in the cells of what rays stand for.
    EXPECT_LT(differenceOf(followed.records, gatheredAnew(glossyRoom(), sites)), 0.02);
    size_t rays = 0;
    for (const GatheredRecord& record : followed.records) {
        ASSERT_NE(record.strata, nullptr);
        rays += record.strata->anchors.size();
    }
    EXPECT_LT(followed.anchors.size(), rays * 2 / 3) << "records share them";
}

TEST(Strata, LightThatDoublesDoublesRecordsInTheSameFrame) {
    Scene brighter = glossyRoom();
    brighter.lights[0].intensity *= 2.0f;
    for (const int order : {shared::DIFFUSE_ORDER, 4}) {
        Followed followed(glossyRoom(), strataSites(12, order));
        const std::vector<GatheredRecord> before = followed.records;
        EXPECT_EQ(followed.follow(brighter), 0);
        for (size_t i = 0; i < before.size(); ++i) {
            EXPECT_EQ(followed.records[i].record.irradiance, 2.0f * before[i].record.irradiance);
            for (size_t k = 0; k < before[i].sh.size(); ++k) {
                EXPECT_EQ(followed.records[i].sh[k], 2.0f * before[i].sh[k]);
            }
        }
    }
}

TEST(Strata, OfARoomWithASpotSayWhatTheRaysSaw) {
    const Scene scene = sceneAt(std::string(SHEEN_SCENES) + "/kite.glb", 0.0);
    const Tracer tracer(scene);
    Random random(3);
    std::vector<RecordSite> sites;
    for (uint32_t i = 0; i < 24; ++i) {
        const vec3 middle(0, 1, 0);
        const vec3 d = random.direction();
        Hit hit;
        tracer.meet({.origin = middle, .directions = {&d, 1}}, &hit);
        const vec3 n =
            shared::faceViewer(geometricNormal(scene, static_cast<int>(hit.triangle)), -d);
        sites.push_back(siteAt(middle + hit.distance * d, n));
        sites.back().seed = pcgHash(i);
    }
    const Followed followed(scene, sites);
    EXPECT_LT(differenceOf(followed.records, gatheredAnew(scene, sites)), 0.01);
}

// ---- What moves ---------------------------------------------------------------------------------

// A room with a board, triangles 12 and 13, that goes aside.
Scene roomWithMovingBoard(float aside) {
    Scene scene;
    const uint32_t walls = addMaterial(scene, diffuseParams(vec3(0.5f)));
    const uint32_t red = addMaterial(scene, diffuseParams(vec3(0.8f, 0.1f, 0.1f)));
    addBox(scene, vec3(-1), vec3(1), walls, true);
    addQuad(scene, vec3(-0.4f + aside, -0.1f, -0.3f), vec3(0, 0, 0.5f), vec3(0.5f, 0.1f, 0), red);
    scene.lights.push_back(pointLight(vec3(0.2f, 0.8f, 0.1f), vec3(1.0f)));
    return scene;
}

const std::vector<uint8_t> kBoardMoves = [] {
    std::vector<uint8_t> moves(14, 0);
    moves[12] = moves[13] = 1;
    return moves;
}();

std::vector<RecordSite> sitesOnWalls() {
    std::vector<RecordSite> sites;
    for (int i = 0; i < 12; ++i) {
        const float a = -0.8f + 0.13f * static_cast<float>(i);
        sites.push_back(i % 2 == 0 ? siteAt(vec3(a, -1, 0.3f), vec3(0, 1, 0))
                                   : siteAt(vec3(-1, a, 0.2f), vec3(1, 0, 0)));
        sites.back().seed = pcgHash(static_cast<uint32_t>(i));
    }
    return sites;
}

// [ray]: whether a record's ray meets the board.
std::vector<bool> meetsBoard(const Scene& scene, const Strata& strata) {
    const Hemisphere h = makeHemisphere(kHemicubeOf24);
    const auto faces = directionsOfFaces(h, tangentFrame(strata.site.normal, 0.0f));
    std::vector<vec3> directions;
    for (int others = 0; others < 2; ++others) {
        for (size_t t = 0; t < strata.more.size(); ++t) {
            const int first = others == 0 ? 0 : 1;
            const int last = others == 0 ? 0 : strata.more[t];
            for (int k = first; k <= last; ++k) {
                directions.push_back(texelRay(h, faces, t, k, strata.site.seed));
            }
        }
    }
    std::vector<Hit> hits(directions.size());
    Tracer(scene).meet({.origin = strata.eye, .directions = directions}, hits.data());
    std::vector<bool> meets;
    for (const Hit& hit : hits) {
        meets.push_back(hit.triangle == 12 || hit.triangle == 13);
    }
    return meets;
}

TEST(Strata, AnOccluderThatMovesFlagsWhatItCoversAndUncovers) {
    const std::vector<RecordSite> sites = sitesOnWalls();
    Followed followed(roomWithMovingBoard(0.0f), sites, kBoardMoves);
    const Hemisphere h = makeHemisphere(kHemicubeOf24);
    const Scene now = roomWithMovingBoard(0.3f);
    const LitScene lit(now);
    followed.anchors.beginFrame(now, kBoardMoves, {}, 0);
    size_t covered = 0, uncovered = 0;
    for (GatheredRecord& record : followed.records) {
        Strata& strata = *record.strata;
        const std::vector<bool> then_met = meetsBoard(roomWithMovingBoard(0.0f), strata);
        const std::vector<bool> now_met = meetsBoard(now, strata);
        const MetByRays met = traceChanged(h, {lit.light}, followed.anchors, strata);
        std::vector<bool> flagged(strata.anchors.size());
        for (const uint32_t i : met.strata) {
            flagged[i] = true;
        }
        for (size_t i = 0; i < flagged.size(); ++i) {
            ASSERT_EQ(flagged[i], then_met[i] || now_met[i]) << i;
            covered += now_met[i] && !then_met[i] ? 1 : 0;
            uncovered += then_met[i] && !now_met[i] ? 1 : 0;
        }
    }
    EXPECT_GT(covered, 100u);
    EXPECT_GT(uncovered, 100u);
}

TEST(Strata, FollowedRecordsAreAsGatheredAnewWhereABoardMoves) {
    const std::vector<RecordSite> sites = sitesOnWalls();
    Followed followed(roomWithMovingBoard(0.0f), sites, kBoardMoves);
    const auto before = gatheredAnew(roomWithMovingBoard(0.0f), sites);
    for (const float aside : {0.1f, 0.2f, 0.3f}) {
        const auto anew = gatheredAnew(roomWithMovingBoard(aside), sites);
        const int64_t rays = followed.follow(roomWithMovingBoard(aside), kBoardMoves);
        EXPECT_LT(rays, int64_t{12} * 24 * 24 * 3 / 2);
        EXPECT_LT(differenceOf(followed.records, anew), 0.02) << aside;
        if (aside == 0.3f) {
            EXPECT_GT(differenceOf(before, anew), 0.05) << "else nothing is tested";
        }
    }
}

TEST(Strata, WhatHasStoppedIsTracedOnceMore) {
    Followed followed(roomWithMovingBoard(0.0f), sitesOnWalls(), kBoardMoves);
    const Scene rest = roomWithMovingBoard(0.3f);
    EXPECT_GT(followed.follow(rest, kBoardMoves), 0);
    EXPECT_GT(followed.follow(rest), 0) << "then it gets anchors";
    EXPECT_EQ(followed.follow(rest), 0);
    const auto at_rest = followed.records;
    EXPECT_GT(followed.follow(roomWithMovingBoard(0.1f), kBoardMoves), 0);
    EXPECT_GT(differenceOf(followed.records, at_rest), 0.02);
}

TEST(Strata, RecordsOnWhatMovesKeepNone) {
    std::vector<RecordSite> sites = sitesOnWalls();
    sites[3].triangle = 12;
    const Followed followed(roomWithMovingBoard(0.0f), sites, kBoardMoves);
    for (size_t i = 0; i < sites.size(); ++i) {
        EXPECT_EQ(followed.records[i].strata == nullptr, i == 3);
    }
}

// ---- Anchors ------------------------------------------------------------------------------------

TEST(Anchors, DroppingUnusedOnesChangesNoRecord) {
    Followed followed(glossyRoom(), strataSites(12, shared::DIFFUSE_ORDER));
    const size_t all = followed.anchors.size();
    followed.records.resize(3);
    const std::vector<GatheredRecord> before = followed.records;
    std::vector<Strata*> strata;
    for (const GatheredRecord& record : followed.records) {
        strata.push_back(record.strata.get());
    }
    dropUnused(followed.anchors, strata);
    EXPECT_LT(followed.anchors.size(), all);
    EXPECT_EQ(followed.follow(glossyRoom()), 0);
    for (size_t i = 0; i < before.size(); ++i) {
        EXPECT_EQ(followed.records[i].record.irradiance, before[i].record.irradiance);
    }
}

Anchors::Met metFrom(const vec3& origin, const vec3& direction, const Scene& scene) {
    Anchors::Met met{
        .origin = origin, .direction = glm::normalize(direction), .solid_angle = 0.01f, .hit = {}};
    Tracer(scene).meet({.origin = origin, .directions = {&met.direction, 1}}, &met.hit);
    return met;
}

TEST(Anchors, AreSharedWhereNormalsAgreeNearby) {
    const Scene scene = roomWithMovingBoard(0.0f);
    Anchors anchors;
    anchors.beginFrame(scene, {}, {}, 0);
    const Anchors::Met met = metFrom(vec3(0.5f, 0, 0), vec3(0.02f, -1, 0.6f), scene);
    const auto added = anchors.findOrAdd(scene, met);
    ASSERT_TRUE(added);
    EXPECT_EQ(anchors.find(scene, met)->anchor, added->anchor);
    EXPECT_EQ(anchors.size(), 1u);
    // From elsewhere at the same place: a Lambertian surface looks alike from all sides.
    const vec3 p = anchors.point(0).position;
    const vec3 eye = p + vec3(-0.5f, 0.9f, -0.4f);
    EXPECT_TRUE(anchors.find(scene, metFrom(eye, p - eye, scene)));
    // Another wall.
    EXPECT_FALSE(anchors.find(scene, metFrom(vec3(0.5f, 0, 0), vec3(1, 0, 0.1f), scene)));
    // What is no longer where it was.
    std::vector<uint8_t> moves(14, 0);
    moves[met.hit.triangle] = 1;
    anchors.beginFrame(scene, moves, {}, 0);
    EXPECT_FALSE(anchors.stands(added->anchor));
    EXPECT_FALSE(anchors.find(scene, met));
}

TEST(Anchors, LieWithinWhatRaysStandFor) {
    const Scene scene = roomWithMovingBoard(0.0f);
    const Tracer tracer(scene);
    Anchors anchors;
    anchors.beginFrame(scene, {}, {}, 0);
    Random random(3);
    size_t shared = 0;
    for (int i = 0; i < 20000; ++i) {
        Anchors::Met met{.origin = random.point(-0.5f, 0.5f),
                         .direction = random.direction(),
                         .solid_angle = 0.1f * std::exp2(-static_cast<float>(i % 8)),
                         .hit = {}};
        tracer.meet({.origin = met.origin, .directions = {&met.direction, 1}}, &met.hit);
        const size_t before = anchors.size();
        const auto link = anchors.findOrAdd(scene, met);
        ASSERT_TRUE(link);
        shared += anchors.size() == before ? 1 : 0;
        const vec3 p = met.origin + met.hit.distance * met.direction;
        const float width = met.hit.distance * std::sqrt(met.solid_angle);
        // The diagonal of a cell whose edge is at most 0.5 sqrt(2) of the width.
        ASSERT_LE(glm::distance(anchors.point(link->anchor).position, p), 1.25f * width) << i;
    }
    EXPECT_GT(shared, 2000u);
}

// Where something has gone from is seen anew as well: glass that was there tinted what lies behind.
TEST(Movers, HideWhatTheyHaveLeft) {
    const Scene before = roomWithMovingBoard(0.0f), now = roomWithMovingBoard(0.4f);
    std::vector<uint8_t> moves(now.triangles.size(), 0);
    size_t board = 0;
    for (size_t t = 0; t < now.triangles.size(); ++t) {
        for (int corner = 0; corner < 3; ++corner) {
            const uint32_t v = now.triangles[t][corner];
            moves[t] |= now.positions[v] != before.positions[v] ? 1 : 0;
        }
        board = moves[t] != 0 ? t : board;
    }
    ASSERT_EQ(moves[board], 1);
    const auto middle = [&](const Scene& scene) {
        const uvec3& t = scene.triangles[board];
        return (scene.positions[t.x] + scene.positions[t.y] + scene.positions[t.z]) / 3.0f;
    };
    const vec3 eye(0.0f, -0.95f, 0.0f);
    const std::vector<vec3> ways = {glm::normalize(middle(now) - eye),
                                    glm::normalize(middle(before) - eye)};
    const std::vector<float> far(2, kInfinity);
    EXPECT_EQ(Movers(now, moves).hide(eye, ways, far), (std::vector<uint8_t>{1, 0}));
    EXPECT_EQ(Movers(now, moves, before.positions).hide(eye, ways, far),
              (std::vector<uint8_t>{1, 1}));
}

TEST(Anchors, RoomForRaysIsBounded) {
    Anchors anchors;
    anchors.beginFrame(Scene(), {}, {}, Anchors::kMostRays - 10);
    EXPECT_FALSE(anchors.claim(11));
    EXPECT_TRUE(anchors.claim(10));
    EXPECT_FALSE(anchors.claim(1));
}

}  // namespace
}  // namespace sheen
