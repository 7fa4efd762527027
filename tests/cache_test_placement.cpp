// Placement with made-up gathers.
#include <gtest/gtest.h>

#include "test_placement.h"

namespace sheen {
namespace {

TEST(Placement, CoversEveryPixelForAnyBatchAndStride) {
    const Stage stage = makeStage(0, 0);
    for (int batch : {1, 8, 64, 100000}) {
        for (int stride : {1, 4, 16, 1024}) {
            PlacementParams params;
            params.batch = batch;
            params.coarsest_stride = stride;
            const Placement placement = place(stage, params);
            SCOPED_TRACE("batch " + std::to_string(batch) + " stride " + std::to_string(stride));
            expectCovered(stage, params, placement);
            EXPECT_GT(placement.cache.records.size(), 0u);
            EXPECT_LT(placement.cache.records.size(),
                      static_cast<size_t>(stage.receivers.counts.seen / 4));
        }
    }
}

TEST(Placement, TheSameBitsEveryTime) {
    const Stage stage = makeStage(0, 4);
    const Change wavy = [](const RecordSite& site, GatheredRecord& g) {
        g.record.radius = 0.5f + 0.4f * std::sin(5.0f * site.position.x);
    };
    expectSame(place(stage, {}, wavy), place(stage, {}, wavy));
}

// In light that is the same everywhere; see Batches in render_test_batches.cpp for real light.
TEST(Placement, BatchesNeedNoMoreRecordsThanTheScan) {
    const Stage stage = makeStage(0, 0);
    PlacementParams linear;
    linear.batch = 1;
    linear.coarsest_stride = 1;
    // Predictions are wrong where nothing is placed yet, but coarse grids spread records evenly.
    EXPECT_LE(place(stage, {}).cache.records.size(), place(stage, linear).cache.records.size());
}

TEST(Placement, NothingSeenNothingPlaced) {
    Stage stage = makeStage(0, 0);
    stage.receivers.footprints.assign(kWidth * kHeight, 0.0f);
    stage.receivers.orders.assign(kWidth * kHeight, kNoOrder);
    const Placement placement = place(stage, {});
    EXPECT_TRUE(placement.cache.records.empty());
    EXPECT_EQ(placement.uncovered, 0);
    Stage empty;
    EXPECT_TRUE(place(empty, {}).cache.records.empty());
}

TEST(Placement, APixelThatNothingServesIsCounted) {
    Stage stage = makeStage(0, 0);
    constexpr int kPixel = kWidth * (kHeight - 1) + kWidth / 2;
    ASSERT_TRUE(stage.receivers.seen(kPixel));
    stage.receivers.normals[kPixel] = vec3(std::nanf(""));
    EXPECT_EQ(place(stage, {}).uncovered, 1);
}

TEST(Placement, GlossyPixelsAreServedByRecordsOfTheirClass) {
    for (const auto& [left, right] : {std::pair(0, 4), std::pair(6, 3), std::pair(10, 0)}) {
        const Stage stage = makeStage(left, right);
        const PlacementParams params;
        const Placement placement = place(stage, params);
        expectCovered(stage, params, placement);
        size_t expected_sh = 0;
        for (const Record& r : placement.cache.records) {
            if (r.order > 0) {
                EXPECT_EQ(static_cast<size_t>(r.sh_first), expected_sh);
                expected_sh += static_cast<size_t>(shLayout(r.order).size());
            }
        }
        EXPECT_EQ(placement.cache.sh.size(), expected_sh);
    }
}

TEST(Placement, HostileRadiiAreClamped) {
    const Stage stage = makeStage(0, 3);
    const PlacementParams params;
    const float values[] = {0.0f, 1e-30f, 1e30f, kInfinity};
    for (float radius : values) {
        const Placement placement = place(
            stage, params, [=](const RecordSite&, GatheredRecord& g) { g.record.radius = radius; });
        expectCovered(stage, params, placement);
        for (const Record& r : placement.cache.records) {
            ASSERT_TRUE(std::isfinite(r.radius));
            const float footprint = footprintOf(stage, r);
            const float reach = params.servingWeight().accuracy * r.radius;
            EXPECT_GE(reach, 0.999f * params.min_pixels * footprint);
            EXPECT_LE(reach, 1.001f * params.overlap * params.max_pixels * footprint);
        }
    }
}

TEST(ReachedBounds, HoldWhatHasWeightAndEndWhereTheReachDoes) {
    const Stage stage = makeStage(0, 0);
    const Receivers& receivers = stage.receivers;
    const PlacementParams params;
    const WeightParams weight = params.servingWeight();
    const auto area = [](const PixelRect& r) { return (r.x1 - r.x0) * (r.y1 - r.y0); };
    int served = 0, reached = 0;
    for (Record k : place(stage, params).cache.records) {
        const PixelRect outer = servedBounds(receivers.image, k, weight);
        const PixelRect rect = reachedBounds(receivers, k, weight);
        served += area(outer);
        reached += area(rect);
        ASSERT_TRUE(rect.x0 >= outer.x0 && rect.x1 <= outer.x1 && rect.y0 >= outer.y0 &&
                    rect.y1 <= outer.y1);
        bool left = false, right = false, bottom = false, top = false;
        for (int y = 0; y < kHeight; ++y) {
            for (int x = 0; x < kWidth; ++x) {
                const size_t i = receivers.image.index(x, y);
                if (!receivers.seen(i)) {
                    continue;
                }
                if (weightAt(receivers, i, k, weight) > 0.0f) {
                    ASSERT_TRUE(x >= rect.x0 && x < rect.x1 && y >= rect.y0 && y < rect.y1);
                }
                if (glm::distance(receivers.positions[i], k.position) <
                    1.001f * weight.accuracy * k.radius) {
                    left |= x == rect.x0;
                    right |= x == rect.x1 - 1;
                    bottom |= y == rect.y0;
                    top |= y == rect.y1 - 1;
                }
            }
        }
        EXPECT_TRUE(left && right && bottom && top);
        k.position += vec3(0, 3.0f * weight.accuracy * k.radius, 0);
        EXPECT_EQ(area(reachedBounds(receivers, k, weight)), 0);
    }
    EXPECT_GT(reached, 0);
    EXPECT_LT(reached, 0.9 * served);
}

TEST(Placement, CurvatureEndsTheReach) {
    const Stage stage = makeStage(0, 0);
    PlacementParams params;
    params.neighbour_clamping = false;
    params.disagreement = 0.0f;
    params.min_pixels = 1.0f;
    params.max_pixels = 1e3f;
    size_t fewer = 0;
    for (float curvature : {0.0f, 0.05f, 0.5f, 3.0f}) {
        const Placement placement = place(stage, params, [=](const RecordSite&, GatheredRecord& g) {
            g.record.radius = 0.8f;
            g.curvature = curvature;
        });
        expectCovered(stage, params, placement);
        for (const Record& r : placement.cache.records) {
            // Error at the end of the reach, d^2 c / 2 E, times the reach in heights of the image.
            const float reach = params.accuracy * r.radius;
            const float error = 0.5f * curvature * reach * reach / luminance(r.irradiance);
            const float tolerated = params.curvature * params.accuracy;
            if (reach < 0.799f) {
                EXPECT_NEAR(error * reach / (kHeight * footprintOf(stage, r)), tolerated,
                            1e-3f * tolerated);
            } else {
                // Never beyond the harmonic mean distance.
                EXPECT_NEAR(reach, 0.8f, 1e-5f);
                EXPECT_LE(error * reach / (kHeight * footprintOf(stage, r)), 1.001f * tolerated);
            }
        }
        EXPECT_GE(placement.cache.records.size(), fewer);
        fewer = placement.cache.records.size() + 1;
    }
    // Curvature without light: the least reach.
    params.min_pixels = 3.0f;
    const Placement dark = place(stage, params, [](const RecordSite&, GatheredRecord& g) {
        g.record.irradiance = vec3(0.0f);
        g.curvature = 1.0f;
    });
    for (const Record& r : dark.cache.records) {
        EXPECT_NEAR(params.accuracy * r.radius, params.min_pixels * footprintOf(stage, r),
                    1e-3f * params.min_pixels * footprintOf(stage, r));
    }
}

// Beside a thin ledge neighbours see quite different light. Each of their records has one pixel to
// serve; farther it would bleed.
TEST(Placement, RecordsServeNoNeighbourThatTheirLightDoesNotAllow) {
    const Stage stage = makeStage(0, 0);
    const PlacementParams params;
    const auto lit = [](const vec3& p) { return p.x > 0.1f; };
    const Placement placement =
        place(stage, params, [&](const RecordSite& site, GatheredRecord& g) {
            g.record.irradiance = vec3(lit(site.position) ? 1.0f : 0.1f);
        });
    expectCovered(stage, params, placement);
    int beside = 0;
    const Receivers& receivers = stage.receivers;
    for (size_t i = 0; i < kWidth * kHeight; ++i) {
        const vec3& p = receivers.positions[i];
        if (!receivers.seen(i) || std::abs(p.x - 0.1f) > receivers.footprints[i]) {
            continue;
        }
        ++beside;
        float sum = 0.0f, light = 0.0f;
        for (const Record& r : placement.cache.records) {
            const float w = weightAt(receivers, i, r, params.servingWeight());
            sum += w;
            light += w * r.irradiance.x;
        }
        const float truth = lit(p) ? 1.0f : 0.1f;
        EXPECT_NEAR(light / sum, truth, 0.1f * truth) << "pixel " << i;
    }
    EXPECT_GT(beside, 20);
}

TEST(Placement, GradientsAreBoundedByTheValue) {
    const Stage stage = makeStage(0, 4);
    const PlacementParams params;
    for (float steepness : {0.1f, 10.0f, 1e6f}) {
        const Placement placement =
            place(stage, params, [=](const RecordSite& site, GatheredRecord& g) {
                g.record.translation_r = vec3(steepness, 0, 0);
                g.record.translation_g = vec3(0, 0, -steepness);
                g.record.irradiance.z = 0.0f;
                g.record.translation_b = vec3(steepness, 0, steepness);
                if (site.order > 0) {
                    const ShLayout layout = shLayout(site.order);
                    for (size_t k = static_cast<size_t>(layout.gradientFirst(0)); k < g.sh.size();
                         ++k) {
                        g.sh[k] = steepness;
                    }
                }
            });
        expectCovered(stage, params, placement);
        for (const Record& r : placement.cache.records) {
            const float reach = params.servingWeight().accuracy * r.radius;
            const vec3 gradients[] = {r.translation_r, r.translation_g, r.translation_b};
            const ShLayout layout = shLayout(r.order);
            for (int c = 0; c < 3; ++c) {
                EXPECT_LE(glm::length(gradients[c]) * reach,
                          params.gradient_limit * r.irradiance[c] * 1.0001f);
                if (r.order == 0) {
                    continue;
                }
                const float* sh = &placement.cache.sh[static_cast<size_t>(r.sh_first)];
                const float value = sh[c * layout.coefficients()];
                float change[2];
                for (int axis = 0; axis < 2; ++axis) {
                    change[axis] =
                        sh[layout.gradientFirst(axis) + c * layout.gradientCoefficients()];
                }
                EXPECT_LE(std::hypot(change[0], change[1]) * reach,
                          params.gradient_limit * value * 1.0001f);
            }
        }
    }
}

TEST(Placement, NoLightIsNoTrouble) {
    const Stage stage = makeStage(0, 4);
    const PlacementParams params;
    const Placement placement = place(stage, params, [](const RecordSite&, GatheredRecord& g) {
        g.record.irradiance = vec3(0.0f);
        std::fill(g.sh.begin(), g.sh.end(), 0.0f);
    });
    expectCovered(stage, params, placement);
    for (const Record& r : placement.cache.records) {
        ASSERT_TRUE(std::isfinite(r.radius));
        ASSERT_EQ(glm::length(r.translation_r), 0.0f);
    }
    for (float c : placement.cache.sh) {
        ASSERT_EQ(c, 0.0f);
    }
}

TEST(Placement, NeighboursAreClampedUnlessAtTheirLeast) {
    const Stage stage = makeStage(0, 0);
    PlacementParams params;
    params.control = ErrorControl::kSplitSphere;
    params.max_pixels = 1e6f;
    params.overlap = 1.0f;
    const Placement placement = place(stage, params, [](const RecordSite& site, GatheredRecord& g) {
        // A near feature that few sites see.
        g.record.radius = std::abs(site.position.x) < 0.3f ? 0.3f : 2.0f;
    });
    expectCovered(stage, params, placement);
    const std::vector<Record>& records = placement.cache.records;
    bool at_limit = false;
    for (const Record& a : records) {
        const float least = params.min_pixels * footprintOf(stage, a) / params.accuracy;
        for (const Record& b : records) {
            const float way = glm::length(a.position - b.position) / params.accuracy;
            const float limit = b.radius + way;
            at_limit |= &a != &b && a.radius > least * 1.001f && a.radius > 0.99f * limit;
            EXPECT_TRUE(a.radius <= limit * 1.0001f || a.radius <= least * 1.001f)
                << a.radius << " limit " << limit << " least " << least;
        }
    }
    EXPECT_GT(records.size(), 20u);
    EXPECT_TRUE(at_limit);
    params.neighbour_clamping = false;
    const Placement free =
        place(stage, params, [](const RecordSite&, GatheredRecord& g) { g.record.radius = 2.0f; });
    for (const Record& r : free.cache.records) {
        EXPECT_EQ(r.radius, 2.0f);
    }
}

TEST(Placement, ScalingTheSceneChangesNoRecord) {
    const Stage one = makeStage(0, 0);
    for (float s : {0.001f, 1000.0f}) {
        const Stage other = makeStage(0, 0, s);
        const Placement a = place(one, {});
        const Placement b =
            place(other, {}, [=](const RecordSite&, GatheredRecord& g) { g.record.radius = s; });
        // Rounding may move a pixel across the limit: a few records may differ.
        const auto n = static_cast<double>(a.cache.records.size());
        EXPECT_NEAR(static_cast<double>(b.cache.records.size()), n, 0.05 * n + 2.0);
        EXPECT_NEAR(b.cache.records[0].radius, s * a.cache.records[0].radius,
                    1e-3f * s * a.cache.records[0].radius);
    }
}

TEST(Placement, SitesFaceTheViewer) {
    // The floor's quad faces up; seen from below its geometric normal must be turned.
    const Stage stage = makeStage(0, 0);
    place(stage, {}, [](const RecordSite& site, GatheredRecord&) {
        EXPECT_NEAR(site.geometric_normal.y, 1.0f, 1e-5f);
        EXPECT_NEAR(site.normal.y, 1.0f, 1e-5f);
    });
}

TEST(Placement, SitesTellHowFarTheirRecordsWillReach) {
    const Stage stage = makeStage(0, 0);
    PlacementParams params;
    params.coarsest_stride = 16;
    params.neighbour_clamping = false;
    params.disagreement = 0.0f;
    for (float radius : {0.0f, 0.3f, kInfinity}) {
        // Only the middle one's reach is free.
        const bool bounded = radius != 0.3f;
        params.max_pixels = bounded ? 6.0f : 1e3f;
        int first = 0, told = 0;
        place(stage, params, [&](const RecordSite& site, GatheredRecord& g) {
            g.record.radius = radius;
            if (site.first) {
                ++first;
                EXPECT_EQ(site.reach, 0.0f);
                return;
            }
            ++told;
            EXPECT_GE(site.reach, 0.999f * params.min_pixels);
            EXPECT_LE(site.reach, 1.001f * params.max_pixels);
            if (!bounded) {
                Record r{};
                r.position = site.position;
                const float expected = radius / footprintOf(stage, r);
                EXPECT_NEAR(site.reach, expected, 1e-3f * expected);
            }
        });
        EXPECT_GT(first, 0);
        EXPECT_GT(told, 4);
    }
}

TEST(Placement, AFieldThatServesAllIsLeftAsItIs) {
    const Stage stage = makeStage(0, 4);
    const Change wavy = [](const RecordSite& site, GatheredRecord& g) {
        g.record.radius = 0.5f + 0.4f * std::sin(5.0f * site.position.x);
    };
    RecordField field;
    const Placement first = place(stage, {}, wavy, &field);
    const Change never = [](const RecordSite&, GatheredRecord&) { ADD_FAILURE() << "gathered"; };
    expectSame(place(stage, {}, never, &field), first);
    EXPECT_EQ(field.records.size(), first.cache.records.size());
}

TEST(Placement, AFinerPassAddsToTheField) {
    const Stage stage = makeStage(0, 4);
    const Change curved = [](const RecordSite&, GatheredRecord& g) { g.curvature = 2.0f; };
    PlacementParams params{.accuracy = 1.0f};
    RecordField field;
    const size_t coarse = place(stage, params, curved, &field).cache.records.size();
    params.accuracy = 0.05f;
    size_t gathered = 0;
    const Change count = [&](const RecordSite& site, GatheredRecord& g) {
        EXPECT_FALSE(site.first);
        curved(site, g);
        ++gathered;
    };
    const Placement fine = place(stage, params, count, &field);
    expectCovered(stage, params, fine);
    EXPECT_EQ(fine.cache.records.size(), coarse + gathered);
    // Hardly more than without any before.
    const size_t anew = place(stage, params, curved).cache.records.size();
    EXPECT_GT(anew, 2 * coarse);
    EXPECT_LT(fine.cache.records.size(), anew + coarse / 2);
}

TEST(Placement, RefusesAGatherThatLosesSites) {
    const Stage stage = makeStage(0, 0);
    struct None : Gatherer {
        std::vector<GatheredRecord> gather(std::span<const RecordSite>) override { return {}; }
    } none;
    RecordField field;
    EXPECT_THROW(placeRecords(stage.scene, stage.receivers, {}, none, field, true),
                 std::logic_error);
}

}  // namespace
}  // namespace sheen
