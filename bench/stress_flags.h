// What is wrong in an image beside the reference's: not the error that interpolation leaves at
// creases, but leaks, blotches, black or bright pixels.
#pragma once

#include <cstdint>

#include "image/frame.h"

namespace sheen {

/// With a: test, b: reference, s: standard deviation of b, by its own or by the mean variance of
/// the 5 x 5 pixels around, whichever is greater (where light is rarely found the replicates of one
/// pixel may all have missed it), and m: the mean of b over the image's
/// pixels with geometry, per channel of the indirect layer: a pixel is flagged where
///     |a - b| > pixel_share b + pixel_floor m + unseen d + sigmas s,
/// a tile of 8 x 8 pixels where the same holds of its means with the tile's shares and the standard
/// deviation of the tile's mean. m takes b as at most `highlight` times its median, so that a
/// highlight hides nothing elsewhere. d is what else the reference's pixel shows, direct light and
/// emission: beside much of it an error is not seen.
///
/// The direct layer has hard edges, which a shadow map draws softly and a texel or two off: a pixel
/// is flagged where it lies outside the range of the reference's pixels around it, by
/// direct_share of the range's upper end and direct_floor of the layer's mean.
struct FlagBounds {
    double pixel_share = 0.5;
    double pixel_floor = 0.3;
    double unseen = 0.02;
    double sigmas = 6.0;  ///< of 16 replicates: their spread is itself uncertain by 18%
    double tile_share = 0.25;
    double tile_floor = 0.1;
    double highlight = 10.0;
    double direct_share = 0.1;
    double direct_floor = 0.1;
    int direct_radius = 2;  ///< in pixels, along both axes
};

/// How bad a pixel or tile is: |a - b| over its bound, flagged above 1.
struct Worst {
    double excess = 0;
    ivec2 at{0};
};

struct Flags {
    int pixels = 0, tiles = 0, direct = 0;
    /// Of `pixels`: those with at least three flagged ones among their eight neighbours. Leaks and
    /// blotches come in patches; noise and what is smaller than a pixel do not.
    int patches = 0;
    Worst pixel, tile, direct_pixel;
    int geometry = 0;        ///< pixels of the reference that see geometry
    int other_triangle = 0;  ///< of all pixels: those that see another triangle; not judged
    int nonfinite = 0;       ///< values of test or reference
    double rel_rmse = 0;     ///< of the indirect layer, docs/metrics.md
    double bias = 0;
    double noise_share = 0;
    bool known = false;   ///< whether the reference is sure enough for rel_rmse to be known
    Image<uint8_t> mask;  ///< 1: indirect, 2: direct, 4: tile, 8: not judged
};

/// Judges the indirect and direct layers of `test` by those of `reference`, which has variances.
Flags flagErrors(const Frame& test, const Frame& reference, const FlagBounds& bounds);

}  // namespace sheen
