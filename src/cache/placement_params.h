// What decides where records go and how far they reach.
#pragma once

#include "record/record.h"

namespace sheen {

/// What a record's own hemisphere says of how far it reaches: the harmonic mean distance of what it
/// sees, limited by the gradient [WRC88] or alone; or the irradiance's second derivative [SJJ12].
enum class ErrorControl { kSplitSphere, kHarmonic, kHessian };

/// Where records go: where a scan of the image finds them missing (scan.h), or first into clusters
/// of receivers (kmeans.h).
enum class SitesBy { kScan, kKMeans };

struct PlacementParams {
    float accuracy = 0.4f;  ///< Ward's a
    ErrorControl control = ErrorControl::kHessian;
    SitesBy sites = SitesBy::kScan;
    int clusters = 0;            ///< kKMeans: of all that is seen, about; 0: by the accuracy
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

}  // namespace sheen
