// Direct light of lamps at the points that pixels see.
#pragma once

#include <functional>
#include <optional>
#include <span>

#include "image/image.h"
#include "light/lamps.h"

namespace sheen {

/// A point whose light is wanted, and what scatters it toward whoever sees it.
struct LitPoint {
    SurfaceSide side;
    Scatterer surface;
};

/// Radiance that lamps send by way of each pixel's point toward the viewer; black where there is
/// none. Paths toward lamps and, where a lobe is narrow, along it are weighted against each other
/// [Vea97]; pixels in penumbrae, and near them, get more of them. `rows_of`: where each row is the
/// samples of one pixel, which share its paths, that pixel's number; empty: rows are an image's.
Image<vec3> lampLight(const Tracer& tracer, const LampSampler& lamps, int width, int height,
                      std::span<const uint32_t> rows_of,
                      const std::function<std::optional<LitPoint>(int x, int y)>& pointAt);

}  // namespace sheen
