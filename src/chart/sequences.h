// How methods do on scenes that move, as bench/sequences.py measured it, for the page.
#pragma once

#include <string>
#include <vector>

namespace sheen {

/// A method on a sequence of frames.
struct SequencePoint {
    std::string scene, method;
    double error = 0;       ///< mean of the frames' rel_rmse
    double flicker = 0;     ///< docs/animation.md
    double resolution = 0;  ///< of the flicker: what is less the reference's noise hides
    double seconds = 0;     ///< a frame, of one processor core
};

struct Sequences {
    std::string measured;  ///< by what, of what and against what, in words
    std::vector<SequencePoint> points;
};

/// Reads what bench/sequences.py --json wrote. Input error where the file is not one, or a figure
/// is negative, or it cannot be read.
Sequences readSequences(const std::string& path);

}  // namespace sheen
