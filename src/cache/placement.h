// Placement: where records are needed so that every pixel is served, and how far each one reaches.
// Based on: [GKB09, algorithm 5], [KBPZ06] for neighbour clamping, [WH92], [War94].
#pragma once

#include <functional>
#include <span>

#include "cache/classes.h"
#include "cache/gather.h"
#include "cache/lobes.h"
#include "cache/record.h"
#include "raster/gbuffer.h"

namespace sheen {

/// What a record's own hemisphere says of how far it reaches: the harmonic mean distance of what it
/// sees, limited by the gradient [WRC88]; or the irradiance's second derivative [SJJ12].
enum class ErrorControl { kSplitSphere, kHessian };

struct PlacementParams {
    float accuracy = 0.4f;  ///< Ward's a
    ErrorControl control = ErrorControl::kHessian;
    float curvature = 5e-4f;     ///< kHessian, times `accuracy`: relative error at the end of a
                                 ///< record's reach times that reach in heights of the image
    float normal_weight = 4.0f;  ///< k_n of the weight function
    float slab = 0.1f;           ///< c of the weight function
    float min_pixels = 0.9f;     ///< least reach a R, in footprints of the record's pixel: above
                                 ///< 0.525, so that it serves its own pixel, and below 1, so that
                                 ///< it serves no other one
    float max_pixels = 30.0f;    ///< greatest reach
    bool neighbour_clamping = true;
    float disagreement = 0.2f;    ///< times `accuracy`: relative error at which a record's reach
                                  ///< should end, as judged by its neighbours; 0: not asked
    int batch = 64;               ///< sites chosen and gathered at once
    int coarsest_stride = 32;     ///< of the grids that are scanned: a power of two
    float gradient_limit = 0.5f;  ///< greatest extrapolated change relative to the value

    float overlap = 1.65f;  ///< how much farther records serve than they were placed for, at most

    /// The weight that decides where records are needed.
    WeightParams weight() const {
        return {.accuracy = accuracy, .normal_weight = normal_weight, .slab = slab};
    }
    /// The weight by which they serve: more of them at each pixel, so that what each one got wrong
    /// by chance averages out. Along the surface: the slab stays as thick as it was.
    WeightParams servingWeight() const {
        return {
            .accuracy = overlap * accuracy, .normal_weight = normal_weight, .slab = slab / overlap};
    }
};

/// Gathers a span of sites, one result each, in order.
using GatherFunction = std::function<std::vector<GatheredRecord>(std::span<const RecordSite>)>;

struct Placement {
    RecordCache cache;
    std::vector<int> pixels;                       ///< that the records lie at
    std::vector<std::vector<Contrast>> contrasts;  ///< that each record found
    int uncovered = 0;  ///< pixels with geometry that no record serves: 0 where numbers are sound
};

/// Where a pixel's light is to be gathered; of the records around it nothing is known yet.
RecordSite siteAt(const Scene& scene, const GBuffer& gbuffer, const PixelClasses& classes,
                  int pixel);

/// Scans the image and gathers records where pixels are not served yet, until all are: first on a
/// coarse grid, then on finer ones, row by row. Sites are chosen `batch` at a time, by predicted
/// radii, and gathered together, so that the gather can run in parallel; the batch is part of the
/// parameters and not of the machine, so the records never depend on the number of threads.
/// A batch of 1 and a stride of 1 is the chapter's linear scan, [GKB09, algorithm 5].
Placement placeRecords(const Scene& scene, const GBuffer& gbuffer, const PixelClasses& classes,
                       const PixelLobes& lobes, const PlacementParams& params,
                       const GatherFunction& gather, bool quiet);

/// Luminance that a pixel sends to the camera by what a record predicts there, by its lobe and
/// reflectance; of the diffuse class the irradiance, since the reflectance cancels in comparisons.
/// `sh`: the record's coefficients.
float outgoingLuminance(const GBuffer& gbuffer, const PixelClasses& classes,
                        const PixelLobes& lobes, const Record& record, const float* sh, int pixel);

/// The mean of the light that a pixel's lobe sees, by a record's coefficients or, of the diffuse
/// class, by its irradiance; what it missed at its own pixel not added.
vec3 lobeLight(const GBuffer& gbuffer, const PixelClasses& classes, const PixelLobes& lobes,
               const Record& record, const float* sh, int pixel);

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
