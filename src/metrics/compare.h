// How far an image is from the reference, and where. Every channel of every compared pixel is one
// sample: colour errors count, and no weighting of channels has to be chosen.
#pragma once

#include <cstdint>
#include <string>

#include "image/image.h"

namespace sheen {

/// Two images of the same layer, linear radiance, [y][x].
struct CompareInput {
    const Image<vec3>& test;
    const Image<vec3>& reference;
    /// Variance of the reference's pixels, or null where it is not known (taken as 0). The test's
    /// errors are assumed to be independent of the reference's.
    const Image<vec3>* reference_variance = nullptr;
    /// Triangle seen by each pixel, or kNoPrimitive. Used where both are given: pixels that see
    /// different triangles are not compared, nor are those that see nothing in both.
    const Image<uint32_t>* test_primitive = nullptr;
    const Image<uint32_t>* reference_primitive = nullptr;
    std::string test_name = "the test image";  ///< in errors
    std::string reference_name = "the reference image";
};

/// With a: test, b: reference, V: the reference's variance, and means over all samples compared.
///
/// A black reference (mean b = 0) has no relative error: all are 0 where the test is black too, and
/// infinite otherwise (bias with the test's sign). Where nothing is compared, all are 0 and
/// `judged` is false.
struct Comparison {
    double rel_rmse = 0;  ///< sqrt(max(0, mean (a-b)^2 - mean V)) / mean b
    double rel_mse = 0;   ///< its square: max(0, mean (a-b)^2 - mean V) / (mean b)^2
    double bias = 0;      ///< mean (a-b) / mean b
    /// Quantiles of the relative error |a-b| / (b + 1% of mean b): the smallest sample that is not
    /// below half, or 99%, of all samples. The reference's noise is included.
    double median = 0, p99 = 0, max = 0;
    /// The median and p99 that a perfect image would have, whose errors are the reference's noise,
    /// taken as normal with variance V: by this reference no image can be shown to be better.
    double noise_median = 0, noise_p99 = 0;
    /// Largest over the tiles of 16 x 16 pixels, counted from the top left and cut by the image's
    /// edge, of sqrt(max(0, tile mean of (a-b)^2 - V)) / (tile mean of b + 5% of mean b).
    double tile_max = 0;
    ivec2 worst_tile{0};     ///< its top left pixel
    double noise_share = 0;  ///< mean V / mean (a-b)^2, at most 1; 0 where a = b everywhere
    int64_t excluded = 0;    ///< pixels not compared because they see different triangles
    int64_t compared = 0;    ///< pixels
    /// False where the reference is too noisy to judge (noise_share above one half) or nothing was
    /// compared: then the figures say more of the reference than of the test.
    bool judged = false;
};

/// Input error where the sizes differ or a sample is not finite (the first one is named).
void checkComparable(const CompareInput& input);

/// Errors as checkComparable().
Comparison compareImages(const CompareInput& input);

/// Relative error of each pixel, mean over channels of |a-b| / (b + 1% of mean b), in false colour:
/// viridis in 253 colours over the decades from 0.1% (dark violet) to 100% (yellow), both ends
/// clamped. Excluded pixels are mid grey, pixels that see nothing black. sRGB-encoded display
/// values in [0, 1]. Errors as compareImages.
Image<vec3> heatmap(const CompareInput& input);

/// The colour map viridis at t in [0, 1] (clamped), sRGB-encoded, within 0.02 of the original
/// table; lightness grows steadily with t. [SvdW15], polynomial fit by [Zuc19]
vec3 viridis(float t);

}  // namespace sheen
