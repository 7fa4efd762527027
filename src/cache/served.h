// Which pixels a record serves.
#pragma once

#include "cache/classes.h"
#include "cache/record.h"
#include "raster/gbuffer.h"

namespace sheen {

/// Rectangle of pixels [x0, x1) x [y0, y1).
struct PixelRect {
    int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
};
/// Bounds in the image, conservatively, what of a sphere lies within half_height of the plane
/// through its centre with that unit normal; the whole image when the sphere comes near the camera;
/// empty when it lies behind.
PixelRect slabBounds(const View& view, int width, int height, const vec3& center, float radius,
                     const vec3& normal, float half_height);

/// The same for the region a record serves: nowhere else is its recordWeight() above 0.
PixelRect servedBounds(const GBuffer& gbuffer, const Record& record, const WeightParams& weight);

/// The least part of these bounds that holds the pixels whose points lie within the record's reach:
/// on flat surfaces little more than it serves, where the above must allow for any surface. Looks
/// at pixels, which pays where a pixel is to cost more than a look.
PixelRect reachedBounds(const GBuffer& gbuffer, const Record& record, const WeightParams& weight);

/// Whether a record of `record_order` serves pixels of `pixel_order`: its own class or a lower one.
inline bool serves(int record_order, int pixel_order) {
    return pixel_order != kNoOrder && record_order >= pixel_order;
}

/// Calls visit(pixel, weight) for the pixels that a record serves, row by row, of those that
/// wanted(pixel).
template <typename Wanted, typename Visit>
void forServed(const GBuffer& gbuffer, const PixelClasses& classes, const Record& k,
               const WeightParams& weight, const Wanted& wanted, const Visit& visit) {
    const PixelRect rect = servedBounds(gbuffer, k, weight);
    for (int y = rect.y0; y < rect.y1; ++y) {
        for (int x = rect.x0; x < rect.x1; ++x) {
            const auto pixel = static_cast<size_t>(y * gbuffer.width + x);
            if (!serves(k.order, classes.orders.pixels[pixel]) || !wanted(pixel)) {
                continue;
            }
            const vec4& p = gbuffer.position.pixels[pixel];
            const float w =
                shared::recordWeight(weight, k.position, k.normal, k.radius, vec3(p),
                                     vec3(gbuffer.normal.pixels[pixel]), p.w * gbuffer.pixel_angle);
            if (w > 0.0f) {
                visit(pixel, w);
            }
        }
    }
}

/// The same for all pixels that it serves.
template <typename Visit>
void forServed(const GBuffer& gbuffer, const PixelClasses& classes, const Record& k,
               const WeightParams& weight, const Visit& visit) {
    forServed(
        gbuffer, classes, k, weight, [](size_t) { return true; }, visit);
}

}  // namespace sheen
