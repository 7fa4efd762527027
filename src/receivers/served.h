// Which receivers a record serves. In an image they are found by what of it the record's region may
// cover, texels of a lightmap, and what glass shows elsewhere than it is, by where they lie.
#pragma once

#include "receivers/receivers.h"
#include "record/record.h"

namespace sheen {

/// Rectangle of pixels [x0, x1) x [y0, y1).
struct PixelRect {
    int x0 = 0, y0 = 0, x1 = 0, y1 = 0;
};
/// Bounds in the image, conservatively, what of a sphere lies within half_height of the plane
/// through its centre with that unit normal; the whole image when the sphere comes near the camera;
/// empty when it lies behind.
PixelRect slabBounds(const PixelGrid& image, const vec3& center, float radius, const vec3& normal,
                     float half_height);

/// The same for the region a record serves: nowhere else is its recordWeight() above 0.
PixelRect servedBounds(const PixelGrid& image, const Record& record, const WeightParams& weight);

/// The least part of these bounds that holds the receivers within the record's reach: on flat
/// surfaces little more than it serves, where the above must allow for any surface. Looks at each,
/// which pays where one is to cost more than a look.
PixelRect reachedBounds(const Receivers& receivers, const Record& record,
                        const WeightParams& weight);

/// Whether a record of `record_order` serves receivers of `order`: its own class or a lower one.
inline bool serves(int record_order, int order) {
    return order != kNoOrder && record_order >= order;
}

/// What a record weighs at a receiver, by where both lie; 0: it does not serve it.
inline float weightAt(const Receivers& receivers, size_t i, const Record& k,
                      const WeightParams& weight) {
    return shared::recordWeight(weight, k.position, k.normal, k.radius, receivers.positions[i],
                                receivers.normals[i], receivers.footprints[i]);
}

/// What a record says of the irradiance at a receiver.
inline vec3 irradianceBy(const Receivers& receivers, size_t i, const Record& k) {
    const vec3& p = receivers.positions[i];
    const vec3& n = receivers.normals[i];
    return receivers.mapped_normals.empty()
               ? shared::recordIrradiance(k, p, n)
               : shared::bumpIrradiance(k, p, n, receivers.mapped_normals[i]);
}

/// Calls visit(i, weight) for the receivers that a record serves, row by row (texels of a lightmap,
/// and before them pixels that glass has bent: in any order), of those that wanted(i).
template <typename Wanted, typename Visit>
void forServed(const Receivers& receivers, const Record& k, const WeightParams& weight,
               const Wanted& wanted, const Visit& visit) {
    const auto look = [&](size_t i) {
        if (!serves(k.order, receivers.orders[i]) || !wanted(i)) {
            return;
        }
        const float w = weightAt(receivers, i, k, weight);
        if (w > 0.0f) {
            visit(i, w);
        }
    };
    if (receivers.places) {
        for (const uint32_t i : receivers.places->within(k.position, weight.accuracy * k.radius)) {
            look(i);
        }
        if (!receivers.outward.empty()) {
            return;
        }
    }
    const PixelRect rect = servedBounds(receivers.image, k, weight);
    for (int y = rect.y0; y < rect.y1; ++y) {
        for (int x = rect.x0; x < rect.x1; ++x) {
            const size_t i = receivers.image.index(x, y);
            if (!receivers.isBent(i)) {
                look(i);
            }
        }
    }
}

/// The same for all that it serves.
template <typename Visit>
void forServed(const Receivers& receivers, const Record& k, const WeightParams& weight,
               const Visit& visit) {
    forServed(
        receivers, k, weight, [](size_t) { return true; }, visit);
}

}  // namespace sheen
