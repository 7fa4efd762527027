// What it took to render a point of the chart.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace sheen {

/// A point is run no more once its warm runs have taken this long in all: long runs vary little.
constexpr double kEnoughSeconds = 60;

/// Who measured: times of different builds or machines do not compare.
struct ChartHost {
    std::string version;
    std::string build;  ///< hash of the executable
    std::string cpu;    ///< model name
    int threads = 0;
};

/// This machine's model of processor.
std::string processorName();

/// Seconds by stage, in the order they ran, and last "other": start-up, exit and what no stage
/// counts.
using StageTimes = std::vector<std::pair<std::string, double>>;

struct TimedRun {
    double seconds = 0;  ///< wall clock of the whole command
    StageTimes stages;
};

struct Measurement {
    ChartHost host;
    std::vector<TimedRun> runs;  ///< warm, as they came
    /// A run with Mesa's shader cache empty; negative where it was not measured: it is for each
    /// method's first setting, since shaders do not depend on the setting.
    double cold_seconds = -1;
    int records = 0;          ///< 0 for a method without
    std::string gl_renderer;  ///< empty for a method without

    /// The median of the runs, of which there must be one.
    double seconds() const;
    /// Of the run nearest to the median; there must be one.
    const StageTimes& stages() const;
    /// Seconds of all runs.
    double spent() const;
    /// Whether there are `repeats` runs, or kEnoughSeconds of them.
    bool isComplete(int repeats) const;
};

/// How many runs of `seconds` each, of at most `most`, complete a measurement whose runs so far
/// took `spent` and do not complete it.
int runsLeft(double seconds, double spent, int most);

}  // namespace sheen
