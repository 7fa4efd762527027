// A value that changes over time, known at some times: what glTF calls an animation sampler.
// Based on: the glTF 2.0 specification, 3.11 and appendix C.
#pragma once

#include <cstddef>
#include <vector>

namespace sheen {

enum class Interpolation {
    kStep,         ///< the value of the last key before
    kLinear,       ///< between two keys; of rotations on the shorter great circle
    kCubicSpline,  ///< a Hermite spline, whose tangents are given
};

/// Keys of one value, which has `width` numbers.
struct Keyframes {
    std::vector<double> times;  ///< seconds, growing; at least one
    /// [key][number]; of a cubic spline [key][tangent that leads there, value, tangent that leads
    /// on][number], tangents per second.
    std::vector<double> values;
    size_t width = 1;
    Interpolation interpolation = Interpolation::kLinear;
    bool rotation = false;  ///< the value is a unit quaternion x, y, z, w
};

/// The value at a time, [number]: before the first key the first one's, after the last the last
/// one's. Rotations are unit. [glTF, appendix C.2 to C.5]
std::vector<double> valueAt(const Keyframes& keys, double seconds);

}  // namespace sheen
