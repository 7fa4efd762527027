// Direct light of lamps at the points that pixels see.
#pragma once

#include <functional>
#include <optional>

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
/// [Vea97]; pixels in penumbrae, and near them, get more of them. `share`: of a pixel's paths that
/// each gets, where several are to make one.
Image<vec3> lampLight(const Tracer& tracer, const LampSampler& lamps, int width, int height,
                      float share,
                      const std::function<std::optional<LitPoint>(int x, int y)>& pointAt);

}  // namespace sheen
