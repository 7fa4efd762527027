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

}  // namespace
}  // namespace sheen
