// Lives of records: how long, what they say meanwhile, and their replacement.
#include <gtest/gtest.h>

#include <set>

#include "cache/temporal.h"
#include "test_placement.h"

namespace sheen {
namespace {

constexpr TemporalParams kParams = {.accuracy = 0.1f, .longest = 8};

GatheredRecord changing(float now, float later) {
    GatheredRecord found;
    found.record.irradiance = vec3(now);
    found.record.order = shared::DIFFUSE_ORDER;
    found.later = GatheredRecord::Later{vec3(later), {}};
    return found;
}

TEST(Temporal, ChangeIsThatOfTheIrradiance) {
    EXPECT_NEAR(changeOf(changing(2.0f, 2.5f)), 0.25f, 1e-6f);
    EXPECT_NEAR(changeOf(changing(2.0f, 1.5f)), 0.25f, 1e-6f);
    EXPECT_EQ(changeOf(changing(2.0f, 2.0f)), 0.0f);
    EXPECT_EQ(changeOf(changing(0.0f, 0.0f)), 0.0f);
    EXPECT_EQ(changeOf(changing(0.0f, 1.0f)), kInfinity);
    EXPECT_EQ(changeOf(GatheredRecord{}), 0.0f) << "nothing that it sees moves";
}

TEST(Temporal, OrThatOfCoefficientsWhereItIsMore) {
    GatheredRecord found = changing(1.0f, 1.1f);
    found.record.order = 2;
    const auto size = static_cast<size_t>(shLayout(2).size());
    found.sh.assign(size, 0.0f);
    found.sh[0] = 3.0f;
    found.sh[5] = 4.0f;
    found.later->sh = found.sh;
    found.later->sh[5] = 6.0f;            // 2 of 5
    found.later->sh[size - 1] = 1000.0f;  // a gradient's
    EXPECT_NEAR(changeOf(found), 0.4f, 1e-6f);
}

TEST(Temporal, RecordsLiveAsLongAsTheirWeightAllows) {
    // Frames n >= 0 with 1 / (change n) > 1 / a_t, a_t = 0.1.
    EXPECT_EQ(lifespanOf(changing(1.0f, 1.04f), kParams), 3);
    EXPECT_EQ(lifespanOf(changing(1.0f, 0.979f), kParams), 5);
    // At n = 4 the weight is 1 / a_t, and not above it.
    EXPECT_EQ(lifespanOf(changing(1.0f, 1.125f), {.accuracy = 0.5f, .longest = 8}), 4);
    EXPECT_EQ(lifespanOf(changing(1.0f, 1.5f), kParams), 1);
    EXPECT_EQ(lifespanOf(changing(0.0f, 1.0f), kParams), 1);
    EXPECT_EQ(lifespanOf(changing(1.0f, 1.001f), kParams), kParams.longest);
    EXPECT_EQ(lifespanOf(GatheredRecord{}, kParams), kParams.longest);
}

TEST(Temporal, MeanwhileLightChangesAsItDidAtFirst) {
    GatheredRecord found = changing(1.0f, 1.25f);
    found.record.order = 2;
    found.sh.assign(static_cast<size_t>(shLayout(2).size()), 1.0f);
    found.later->sh.assign(found.sh.size(), 0.5f);
    for (int frame = 1; frame <= 4; ++frame) {
        growOlder(found, kParams);
        EXPECT_EQ(found.age, frame);
        EXPECT_FLOAT_EQ(found.record.irradiance.y, 1.0f + 0.25f * static_cast<float>(frame));
        EXPECT_FLOAT_EQ(found.sh[11], 1.0f - 0.5f * static_cast<float>(frame));
        EXPECT_FLOAT_EQ(found.sh[12], 1.0f) << "gradients stay";
    }
}

TEST(Temporal, IrradianceDoesNotBecomeNegative) {
    GatheredRecord found = changing(1.0f, 0.4f);
    for (int frame = 0; frame < 5; ++frame) {
        growOlder(found, kParams);
        EXPECT_GE(found.record.irradiance.x, 0.0f);
    }
    EXPECT_EQ(found.record.irradiance.x, 0.0f);
}

TEST(Temporal, WithoutExtrapolationItStays) {
    TemporalParams params = kParams;
    params.gradients = TemporalGradients::kNone;
    GatheredRecord found = changing(1.0f, 1.25f);
    growOlder(found, params);
    EXPECT_EQ(found.record.irradiance.x, 1.0f);
    EXPECT_EQ(found.age, 1);
}

// ---- Interpolated gradients ---------------------------------------------------------------------

constexpr TemporalParams kInterpolated = {
    .accuracy = 0.1f, .longest = 8, .gradients = TemporalGradients::kInterpolated};

Life lifeOfFour() {
    Life life{.first = changing(1.0f, 2.0f), .next = changing(3.0f, 3.0f), .frames = 4};
    life.first.record.radius = 2.0f;
    life.next->record.radius = 4.0f;
    life.next->record.translation_g = vec3(0.0f, 8.0f, 0.0f);
    life.next->record.missed_b = -1.0f;
    life.next->curvature = 6.0f;
    life.first.sh = {1.0f, 5.0f};
    life.next->sh = {5.0f, 1.0f};
    return life;
}

TEST(Temporal, ARecordBetweenIsOnTheLineBetweenItsEnds) {
    const Life life = lifeOfFour();
    for (int age = 0; age <= 4; ++age) {
        const GatheredRecord found = recordAt(life, age);
        const float t = 0.25f * static_cast<float>(age);
        EXPECT_EQ(found.age, age);
        EXPECT_FLOAT_EQ(found.record.irradiance.x, 1.0f + 2.0f * t);
        EXPECT_FLOAT_EQ(found.record.radius, 2.0f + 2.0f * t);
        EXPECT_FLOAT_EQ(found.record.translation_g.y, 8.0f * t);
        EXPECT_FLOAT_EQ(found.record.missed_b, -t);
        EXPECT_FLOAT_EQ(found.curvature, 6.0f * t);
        EXPECT_FLOAT_EQ(found.sh[0], 1.0f + 4.0f * t);
        EXPECT_FLOAT_EQ(found.sh[1], 5.0f - 4.0f * t);
    }
}

TEST(Temporal, WhereLightJumpsOrNothingFollowsItStays) {
    Life jumps = lifeOfFour();
    jumps.jumps = true;
    EXPECT_EQ(recordAt(jumps, 3).record.irradiance.x, 1.0f);
    Life goes_on = lifeOfFour();
    goes_on.next.reset();
    EXPECT_EQ(recordAt(goes_on, 3).record.irradiance.x, 1.0f);
    EXPECT_EQ(recordAt(goes_on, 3).sh[1], 5.0f);
}

TEST(Temporal, WitnessesTellWhetherLightJumps) {
    // A change of up to thrice the accuracy may have come since the frame before.
    for (const auto& [change, jumps] : {std::pair(0.05f, false), {0.29f, false}, {0.31f, true}}) {
        RecordField field;
        field.records = {changing(1.0f, 1.0f)};
        beginLives(field, 0, kInterpolated, false);
        GatheredRecord& found = field.records[0];
        const std::shared_ptr<Life> life = found.life;
        growOlder(found, kInterpolated);
        growOlder(found, kInterpolated);
        endLife(found, changing(2.0f, 2.0f), change, kInterpolated);
        EXPECT_EQ(life->frames, 2);
        EXPECT_EQ(life->jumps, jumps) << change;
        EXPECT_EQ(life->first.record.irradiance.x, 1.0f);
        EXPECT_EQ(life->next->record.irradiance.x, 2.0f);
        EXPECT_EQ(life->first.life, nullptr) << "none would ever be freed";
        // They err by chance: what was gathered must agree.
        endLife(found, changing(1.29f, 1.29f), change, kInterpolated);
        EXPECT_FALSE(life->jumps);
    }
}

TEST(Temporal, TheFirstRecordsEndAtDifferentTimes) {
    RecordField field;
    for (int i = 0; i < 800; ++i) {
        GatheredRecord found;
        found.record.position = vec3(0.01f * static_cast<float>(i), 0.0f, 1.0f);
        field.records.push_back(found);
        field.pixels.push_back(i);
    }
    beginLives(field, 0, kParams, true);
    std::vector<int> ends(static_cast<size_t>(kParams.longest) + 1, 0);
    for (const GatheredRecord& found : field.records) {
        ASSERT_GE(found.lifespan, 1);
        ASSERT_LE(found.lifespan, kParams.longest);
        ++ends[static_cast<size_t>(found.lifespan)];
    }
    for (int n = 1; n <= kParams.longest; ++n) {
        // 100 on average, whose standard deviation is 9.4.
        EXPECT_NEAR(ends[static_cast<size_t>(n)], 100, 40) << n;
    }
    beginLives(field, 100, kParams, false);
    EXPECT_EQ(field.records[799].lifespan, kParams.longest);
    beginLives(field, 0, kInterpolated, true);
    std::set<int> lives;
    for (const GatheredRecord& found : field.records) {
        lives.insert(found.lifespan);
    }
    EXPECT_EQ(lives, (std::set<int>{4, 5, 6, 7, 8})) << "a line of one frame would be a step";
}

// Records on the floor of a stage, some of whose lives have ended.
struct OldRecords {
    Stage stage = makeStage(shared::DIFFUSE_ORDER, shared::DIFFUSE_ORDER);
    PlacementParams placement;
    RecordField field;

    OldRecords() {
        place(stage, placement, kNoChange, &field);
        for (size_t k = 0; k < field.records.size(); ++k) {
            field.records[k].age = static_cast<int>(k % 5);
            field.records[k].lifespan = 4;
        }
    }
    size_t renewBy(const Ageing& ageing, const Change& change) {
        MadeUpGatherer gatherer(change);
        return renew(stage.scene, stage.receivers, placement, ageing, gatherer, field);
    }
};

// Says of every other record that it has changed.
class NoticingGatherer : public MadeUpGatherer {
  public:
    using MadeUpGatherer::MadeUpGatherer;
    std::vector<float> changesSince(std::span<const GatheredRecord* const> records) override {
        std::vector<float> changes;
        for (const GatheredRecord* found : records) {
            EXPECT_GT(found->age, 0) << "those of now are as they are";
            EXPECT_LT(found->age, found->lifespan) << "those that end are not asked";
            changes.push_back(changes.size() % 2 == 0 ? 0.11f : 0.09f);
        }
        asked = records.size();
        return changes;
    }
    size_t asked = 0;
};

const Change kBrighter = [](const RecordSite&, GatheredRecord& g) {
    g.record.irradiance = vec3(9.0f);
};

TEST(Temporal, EndedRecordsAreReplacedAtTheirPlaces) {
    OldRecords old;
    const RecordField before = old.field;
    std::multiset<float> asked;
    const size_t renewed =
        old.renewBy({.params = kParams}, [&](const RecordSite& site, GatheredRecord& g) {
            asked.insert(site.position.x);
            kBrighter(site, g);
        });
    size_t ended = 0;
    for (size_t k = 0; k < before.records.size(); ++k) {
        const GatheredRecord& was = before.records[k];
        const GatheredRecord& is = old.field.records[k];
        EXPECT_EQ(is.record.position, was.record.position);
        if (was.age == 4) {
            ++ended;
            EXPECT_EQ(is.record.irradiance.x, 9.0f);
            EXPECT_EQ(is.age, 0);
            EXPECT_EQ(is.lifespan, kParams.longest);
        } else {
            EXPECT_EQ(is.record.irradiance, was.record.irradiance);
            EXPECT_EQ(is.age, was.age);
        }
    }
    EXPECT_EQ(renewed, ended);
    EXPECT_EQ(asked.size(), ended);
    EXPECT_GT(ended, 0u);
    EXPECT_EQ(old.field.pixels, before.pixels);
}

TEST(Temporal, RecordsOnWhatMovedAreAllReplaced) {
    OldRecords old;
    const size_t renewed = old.renewBy({.params = kParams, .moved = {1, 0}}, kBrighter);
    EXPECT_EQ(renewed, old.field.records.size());
    for (size_t k = 0; k < old.field.records.size(); ++k) {
        EXPECT_EQ(old.field.records[k].record.position,
                  old.stage.receivers.positions[static_cast<size_t>(old.field.pixels[k])]);
    }
}

TEST(Temporal, RecordsWhoseLightHasChangedAreReplacedToo) {
    OldRecords old;
    size_t ended = 0, young = 0;
    for (const GatheredRecord& found : old.field.records) {
        ended += found.age == 4 ? 1 : 0;
        young += found.age == 0 ? 1 : 0;
    }
    NoticingGatherer gatherer(kBrighter);
    const size_t renewed = renew(old.stage.scene, old.stage.receivers, old.placement,
                                 {.params = kParams}, gatherer, old.field);
    EXPECT_EQ(gatherer.asked, old.field.records.size() - ended - young);
    EXPECT_EQ(renewed, ended + (gatherer.asked + 1) / 2);
}

TEST(Temporal, WhatReplacesARecordEndsItsLifeAndBeginsAnother) {
    OldRecords old;
    std::vector<std::shared_ptr<Life>> lives;
    beginLives(old.field, 0, kInterpolated, false);
    for (size_t k = 0; k < old.field.records.size(); ++k) {
        lives.push_back(old.field.records[k].life);
        old.field.records[k].age = static_cast<int>(k % 5);
        old.field.records[k].lifespan = 4;
    }
    old.renewBy({.params = kInterpolated}, kBrighter);
    for (size_t k = 0; k < lives.size(); ++k) {
        const bool ended = k % 5 == 4;
        EXPECT_EQ(lives[k]->next.has_value(), ended);
        EXPECT_EQ(old.field.records[k].life == lives[k], !ended);
        if (ended) {
            EXPECT_EQ(lives[k]->frames, 4);
            EXPECT_EQ(lives[k]->next->record.irradiance.x, 9.0f);
            EXPECT_EQ(old.field.records[k].life->first.record.irradiance.x, 9.0f);
        }
    }
}

TEST(Temporal, OfNoRecordsNoneIsReplaced) {
    OldRecords old;
    old.field = {};
    EXPECT_EQ(old.renewBy({.params = kParams}, kBrighter), 0u);
}

}  // namespace
}  // namespace sheen
