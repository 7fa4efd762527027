// How methods do on scenes that move, and at baking lightmaps, as programs in bench/ measured it,
// for the page.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <optional>
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

/// A lightmap baked.
struct BakePoint {
    std::string scene, method;
    std::string setting;  ///< the value of its option
    double error = 0;     ///< rel_rmse over the texels
    bool judged = true;   ///< else the error is mostly the reference's noise
    double share = 0;     ///< hemispheres gathered, of the texels; 0: paths
    double seconds = 0;   ///< of one processor core
};

template <class Point>
struct BenchPoints {
    std::string measured;  ///< by what, of what and against what, in words
    std::vector<Point> points;
};
using Sequences = BenchPoints<SequencePoint>;
using Bakes = BenchPoints<BakePoint>;

/// Reads what bench/sequences.py --json or bench/bake.py --json wrote. Input error where the file
/// is not one, or a figure is negative, or it cannot be read.
Sequences readSequences(const std::string& path);
Bakes readBakes(const std::string& path);

/// As these files hold them; null where there are none.
nlohmann::ordered_json jsonOf(const std::optional<Sequences>& sequences);
nlohmann::ordered_json jsonOf(const std::optional<Bakes>& bakes);

}  // namespace sheen
