// How much the error of a sequence of images changes from frame to frame: what is seen as flicker,
// whatever the error itself is.
#pragma once

#include <optional>

#include "metrics/compare.h"

namespace sheen {

/// With a_n: the test's frame n, b_n: the reference's, V_n: its variance, and means over all
/// channels of all pixels of all pairs of neighbouring frames:
///     value = sqrt(max(0, mean(d^2 - V))) / mean b,
///     d = (a_n+1 - a_n) - (b_n+1 - b_n), V = V_n + V_n+1.
/// Where the reference stands still this is the change of the test alone; noise of deviation s,
/// drawn anew in every frame, makes it sqrt(2) s, and none where it is the same in each.
struct Flicker {
    double value = 0;
    /// Flicker below this cannot be told from none: the fourth root of what the reference's noise,
    /// taken as normal, adds to the variance of that mean, over mean b.
    double resolution = 0;
    double noise_share = 0;  ///< mean V / mean d^2, at most 1
    int pairs = 0;           ///< of neighbouring frames
};

/// Adds up frames as they come.
class FlickerMeter {
  public:
    /// A frame, by its number: with the one added before it makes a pair where their numbers are
    /// neighbours. In pairs count pixels whose triangles are the same in test and reference, in
    /// both frames, and which see something in one. The noise of two references that are the same
    /// in all bits is one and changes nothing. Errors as compareImages(), and where sizes differ
    /// from the frame before.
    void add(int frame, const CompareInput& input);

    /// None where there was no pair with pixels to compare.
    std::optional<Flicker> result() const;

  private:
    struct Kept {
        int frame = 0;
        Image<vec3> test, reference, variance;
        Image<uint32_t> test_primitive, reference_primitive;
    };
    void addPair(const Kept& before, const Kept& after);

    std::optional<Kept> last_;
    int pairs_ = 0;
    int64_t samples_ = 0;
    double squared_ = 0, variance_ = 0, reference_ = 0, spread_ = 0;
};

}  // namespace sheen
