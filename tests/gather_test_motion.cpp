// What records will see by the motion that is known, against what rays see then.
#include <gtest/gtest.h>

#include "gather/integrate.h"
#include "gather/motion.h"
#include "gather/ray_gather.h"
#include "test_light.h"
#include "test_scenes.h"
#include "test_sites.h"

namespace sheen {
namespace {

const Hemisphere& hemicube() {
    static const Hemisphere h = makeHemisphere({.kind = HemisphereKind::kHemicube, .size = 32});
    return h;
}

constexpr float kWalls = 0.1f, kBoard = 1.0f;

// A room with a board in it, whose corners are vertices 24 to 27.
Scene roomWithBoard(const vec3& corner, const vec3& u, const vec3& v) {
    Scene scene;
    const uint32_t m = addMaterial(scene, diffuseParams(vec3(0.5f)));
    addBox(scene, vec3(-1), vec3(1), m, true);
    addQuad(scene, corner, u, v, m);
    return scene;
}

// By a ray through the middle of each texel: the board is bright, all else is not.
std::vector<vec4> seenFrom(const Scene& scene, const RecordSite& site) {
    const Hemisphere& h = hemicube();
    const mat3 frame = tangentFrame(site.normal, 0.0f);
    std::vector<vec3> directions;
    for (const vec3& d : h.directions) {
        directions.push_back(frame * d);
    }
    std::vector<Hit> hits(directions.size());
    Tracer(scene).meet({.origin = site.eye(), .directions = directions}, hits.data());
    std::vector<vec4> seen;
    for (const Hit& hit : hits) {
        const float light = hit.triangle == 12 || hit.triangle == 13 ? kBoard : kWalls;
        seen.push_back(hit.found() ? vec4(vec3(light), hit.distance) : vec4(0.0f));
    }
    return seen;
}

float irradianceOf(const std::vector<vec4>& texels) {
    float sum = 0.0f;
    for (size_t t = 0; t < texels.size(); ++t) {
        sum += hemicube().cosines[t] * texels[t].x;
    }
    return sum;
}

double sameShare(const std::vector<vec4>& a, const std::vector<vec4>& b) {
    size_t same = 0;
    for (size_t t = 0; t < a.size(); ++t) {
        same += a[t].x == b[t].x ? 1 : 0;
    }
    return static_cast<double>(same) / static_cast<double>(a.size());
}

const RecordSite kFloor = siteAt(vec3(0.1f, -1.0f, 0.05f), vec3(0, 1, 0));

struct Move {
    const char* name;
    vec3 by;
};

class MotionOf : public testing::TestWithParam<Move> {};

TEST_P(MotionOf, ABoardIsForeseenAsRaysSeeIt) {
    const vec3 corner(-0.3f, -0.2f, -0.25f), u(0.0f, 0.0f, 0.5f), v(0.6f, 0.1f, 0.0f);
    const Scene now = roomWithBoard(corner, u, v);
    const Scene then = roomWithBoard(corner + GetParam().by, u, v);
    const Motion motion(now, then.positions);
    EXPECT_TRUE(motion.any());
    EXPECT_FALSE(motion.moves(0));
    EXPECT_TRUE(motion.moves(12));
    const std::vector<vec4> before = seenFrom(now, kFloor), after = seenFrom(then, kFloor);
    const auto foreseen = motion.reproject(hemicube(), kFloor, before);
    ASSERT_TRUE(foreseen);
    // Geometry is known, and walls and board have one radiance each.
    EXPECT_LT(sameShare(before, after), 0.98) << "else nothing is tested";
    EXPECT_EQ(sameShare(*foreseen, after), 1.0);
    const float change = irradianceOf(after) - irradianceOf(before);
    EXPECT_NEAR(irradianceOf(*foreseen) - irradianceOf(before), change, 1e-5f);
}

INSTANTIATE_TEST_SUITE_P(All, MotionOf,
                         testing::Values(Move{"Aside", vec3(0.35f, 0, 0.1f)},
                                         Move{"Down", vec3(0.15f, -0.15f, 0)},
                                         Move{"Up", vec3(0.3f, 0.3f, 0)}),
                         [](const auto& info) { return std::string(info.param.name); });

TEST(Motion, WhereNothingMovesNothingIsForeseen) {
    const Scene scene = roomWithBoard(vec3(-0.3f, 0, -0.3f), vec3(0, 0, 0.5f), vec3(0.6f, 0, 0));
    const Motion still(scene, scene.positions);
    EXPECT_FALSE(still.any());
    EXPECT_FALSE(still.reproject(hemicube(), kFloor, seenFrom(scene, kFloor)));
}

TEST(Motion, APointKeepsItsRadiance) {
    // A board of two halves that goes aside by half its length: each half takes its own along.
    Scene now = roomWithBoard(vec3(-0.4f, -0.2f, -0.2f), vec3(0, 0, 0.4f), vec3(0.4f, 0, 0));
    addQuad(now, vec3(0.0f, -0.2f, -0.2f), vec3(0, 0, 0.4f), vec3(0.4f, 0, 0), 0);
    Scene then = now;
    for (size_t i = 24; i < 32; ++i) {
        then.positions[i].x -= 0.4f;
    }
    const auto before = seenFrom(now, kFloor), after = seenFrom(then, kFloor);  // one half is dark
    const auto foreseen = Motion(now, then.positions).reproject(hemicube(), kFloor, before);
    ASSERT_TRUE(foreseen);
    // Along their common edge texels of now hold either.
    EXPECT_GT(sameShare(*foreseen, after), 0.98);
    EXPECT_LT(sameShare(before, after), 0.96) << "else nothing is tested";
}

TEST(Motion, WhatIsHiddenIsNotForeseen) {
    // From the ceiling nothing is seen of a board that moves beneath another one that does not.
    const auto scene = [](float aside) {
        Scene s =
            roomWithBoard(vec3(-0.2f + aside, -0.9f, -0.2f), vec3(0, 0, 0.3f), vec3(0.3f, 0, 0));
        addQuad(s, vec3(-0.9f, -0.5f, -0.9f), vec3(0, 0, 1.8f), vec3(1.8f, 0, 0), 0);
        return s;
    };
    const RecordSite ceiling = siteAt(vec3(0, 1, 0), vec3(0, -1, 0));
    const Motion motion(scene(0.0f), scene(0.1f).positions);
    EXPECT_TRUE(motion.any());
    EXPECT_FALSE(motion.reproject(hemicube(), ceiling, seenFrom(scene(0.0f), ceiling)));
}

TEST(Motion, WhatGoesBehindSomethingIsSeenNoMore) {
    // The board moves to where a nearer one hides all of it; its gap is filled by what is beside.
    const auto scene = [](float aside) {
        Scene s =
            roomWithBoard(vec3(-0.8f + aside, 0.2f, -0.2f), vec3(0, 0, 0.3f), vec3(0.3f, 0, 0));
        addQuad(s, vec3(0.2f, -0.5f, -0.5f), vec3(0, 0, 1.0f), vec3(0.8f, 0, 0), 0);
        return s;
    };
    const Motion motion(scene(0.0f), scene(1.4f).positions);
    const std::vector<vec4> before = seenFrom(scene(0.0f), kFloor);
    const auto foreseen = motion.reproject(hemicube(), kFloor, before);
    ASSERT_TRUE(foreseen);
    EXPECT_GT(irradianceOf(before), irradianceOf(*foreseen) + 0.01f);
    for (const vec4& texel : *foreseen) {
        EXPECT_TRUE(texel.x == kWalls || texel.x == 0.0f) << texel.x;
    }
}

TEST(Motion, WhatStandsStillIsAsItWas) {
    const Scene now = roomWithBoard(vec3(-0.3f, 0, -0.3f), vec3(0, 0, 0.5f), vec3(0.6f, 0, 0));
    Scene then = now;
    for (size_t i = 24; i < 28; ++i) {
        then.positions[i].x += 0.2f;
    }
    const std::vector<vec4> before = seenFrom(now, kFloor);
    const auto foreseen = Motion(now, then.positions).reproject(hemicube(), kFloor, before);
    ASSERT_TRUE(foreseen);
    for (size_t t = 0; t < before.size(); ++t) {
        if (before[t].x == kWalls && (*foreseen)[t].x == kWalls) {
            EXPECT_EQ(before[t], (*foreseen)[t]) << t;
        }
    }
}

// ---- Witnesses ----------------------------------------------------------------------------------

std::vector<float> changesBetween(const Scene& then, const Scene& now, int order) {
    const LitByCells lit_then(then), lit_now(now);
    const Motion still(then, then.positions);
    RayGatherer gatherer(lit_then.light, {.kind = HemisphereKind::kHemicube, .size = 24});
    gatherer.lookAheadBy(still);
    std::vector<RecordSite> sites = sitesInGlossyRoom(12);
    for (RecordSite& site : sites) {
        site.order = order;
    }
    const std::vector<GatheredRecord> records = gatherer.gather(sites);
    std::vector<const GatheredRecord*> asked;
    for (const GatheredRecord& record : records) {
        EXPECT_FALSE(record.later);
        EXPECT_FALSE(record.witnesses.empty());
        asked.push_back(&record);
    }
    return RayGatherer(lit_now.light, {.kind = HemisphereKind::kHemicube, .size = 24})
        .changesSince(asked);
}

TEST(Witnesses, WhereNothingChangesTheySayNothing) {
    for (const int order : {shared::DIFFUSE_ORDER, 4}) {
        for (const float change : changesBetween(glossyRoom(), glossyRoom(), order)) {
            EXPECT_EQ(change, 0.0f);
        }
    }
}

TEST(Witnesses, TheyTellByHowMuchLightChanges) {
    Scene brighter = glossyRoom();
    brighter.lights[0].intensity *= 1.25f;
    for (const int order : {shared::DIFFUSE_ORDER, 4}) {
        for (const float change : changesBetween(glossyRoom(), brighter, order)) {
            EXPECT_NEAR(change, 0.2f, 1e-3f) << "of the larger one; cells round light";
        }
    }
}

TEST(Witnesses, RecordsWithoutAnyAreTakenAsTheyAre) {
    const Scene scene = glossyRoom();
    const LitByCells lit(scene);
    RayGatherer gatherer(lit.light, {.kind = HemisphereKind::kHemicube, .size = 24});
    const std::vector<GatheredRecord> records = gatherer.gather(sitesInGlossyRoom(1));
    EXPECT_TRUE(records[0].witnesses.empty());
    const GatheredRecord* asked = records.data();
    EXPECT_EQ(gatherer.changesSince({&asked, 1}), std::vector<float>{0.0f});
}

}  // namespace
}  // namespace sheen
