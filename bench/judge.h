// What the program `judge` does: studies that judge the program by its reference.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace sheen::bench {

/// Names of judgePoints()'s studies.
const std::vector<std::string>& pointStudies();

/// Each approximation alone against rays at the same points: writes CSV files for the plots and
/// Markdown tables of docs/accuracy/README.md into `output`. `scenes`: the folder of the scenes;
/// `records`: points a scene at most, 0: as the page has; no study: all.
void judgePoints(const std::string& scenes, const std::string& output, int records,
                 const std::vector<std::string>& studies);

/// Renders a scene with some of the parameters changed that `sheen render` has no option for, as
/// KEY=VALUE, and prints one line: cost, and error of the indirect layer. KEY=@N searches the
/// value, above 0, that takes N records within 3%: error controls are compared at equal numbers.
void sweep(const std::string& scene, const std::string& reference,
           const std::vector<std::string>& settings);

struct StressOptions {
    uint32_t first = 0, last = 199;  ///< seeds
    int size = 48;
    int spp = 256;
    int most = 1024;   ///< paths a pixel, where fewer leave the error unknown
    std::string keep;  ///< folder for images of flagged seeds; empty: none
    bool keep_all = false;
};

/// Renders random scenes (stress_scenes.h) by the cache and by the reference, and flags what is off
/// by more than the bounds of stress_flags.h; and whether the error lies in the interval that the
/// render prints. A line a scene; docs/stability.md says what it found. Returns whether none is
/// flagged.
bool stress(const StressOptions& options);

}  // namespace sheen::bench
