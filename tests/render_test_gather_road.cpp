#include <gtest/gtest.h>

#include "render/gather_road.h"
#include "render/render.h"

namespace sheen {
namespace {

// A stretched plane takes the texels of a hemicube, and looks less far aside.
TEST(GatherSize, ABorderHasItsOwnDefaults) {
    EXPECT_EQ(gatherSize(GatherRoad::kRaster, 0.4f), 38);
    EXPECT_EQ(gatherSize(GatherRoad::kRaster, 0.4f, HemisphereKind::kBorder), 66);
    EXPECT_EQ(gatherExtent(HemisphereKind::kBorder), 2.5f);
    EXPECT_EQ(gatherExtent(HemisphereKind::kPlane), 3.0f);
    RenderParams defaults;
    EXPECT_EQ(defaults.gather.size, 0);  // chosen by the kind and the accuracy
    EXPECT_EQ(defaults.gather.extent, 0.0f);
}

TEST(CheaperRoad, IsTheOneThatCostsLess) {
    const RoadCosts costs = {
        .rays = {1.0, 0.0, 0.0}, .raster = {0.0, 0.1, 1.0}, .raster_equal_error = 2.0};
    EXPECT_EQ(cheaperRoad(costs, 4).road, GatherRoad::kRaster);  // 0.8 against 1
    EXPECT_EQ(cheaperRoad(costs, 5).road, GatherRoad::kRays);    // as much
    EXPECT_EQ(cheaperRoad(costs, 6).road, GatherRoad::kRays);
    EXPECT_DOUBLE_EQ(cheaperRoad(costs, 4).raster_ratio, 0.8);
}

// What `bench/stages` measured on a quiet machine, milliseconds a record, both threads: by rays of
// 18 texels, and by the rasteriser, hemicube 38. Slower days change both alike
// (docs/performance.md).
TEST(CheaperRoad, PredictsWhatTheStagesTake) {
    struct Measured {
        int triangles;
        double rays, raster;
    };
    constexpr double kFit = 1.7;  // scenes differ by more than their triangles
    for (const Measured& m :
         {Measured{30, 0.0911, 0.319}, Measured{1'080, 0.128, 0.425}, Measured{5'070, 0.157, 0.777},
          Measured{69'120, 0.246, 1.78}, Measured{1'004'670, 0.518, 14.0},
          Measured{23'862, 0.137, 1.22}, Measured{75'682, 0.451, 4.28}}) {
        SCOPED_TRACE(m.triangles);
        const double rays = kSoftwareCosts.rays.milliseconds(m.triangles);
        const double raster = kSoftwareCosts.raster.milliseconds(m.triangles);
        EXPECT_LT(rays, kFit * m.rays);
        EXPECT_GT(rays, m.rays / kFit);
        EXPECT_LT(raster, kFit * m.raster);
        EXPECT_GT(raster, m.raster / kFit);
    }
}

TEST(CheaperRoad, RaysWinOnTheSoftwareRasteriserAtAnySize) {
    constexpr double kLeast = 8.0;  // docs/decisions.md: 10 to 29 times in real scenes
    for (int triangles : {0, 1, 30, 1'000, 100'000, 10'000'000, 2'000'000'000}) {
        const RoadChoice choice = cheaperRoad(kSoftwareCosts, triangles);
        EXPECT_EQ(choice.road, GatherRoad::kRays) << triangles;
        EXPECT_GT(choice.raster_ratio, kLeast) << triangles;
    }
}

}  // namespace
}  // namespace sheen
