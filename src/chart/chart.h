// Error against time of every method, measured: what `sheen chart` does before it writes its
// report. Each point is a whole `sheen render`, run as a child process as a user runs it. What was
// measured is kept in the chart's folder, so that an interrupted chart continues where it was.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "chart/benches.h"
#include "chart/measurement.h"
#include "chart/methods.h"
#include "metrics/compare.h"
#include "scene/environment.h"

namespace sheen {

struct ChartParams {
    std::vector<std::string> scenes;  ///< glTF files
    std::string folder;               ///< made where it is missing
    std::string program;              ///< the executable that renders: sheen's own
    std::string version;
    std::string camera;             ///< of every scene: name or index; empty: the first
    EnvironmentParams environment;  ///< of every scene
    int width = 512;
    int height = 512;
    int bounces = 1;                                          ///< kAllBounces: all
    std::vector<SweepMethod> methods = chooseMethods({}, 1);  ///< that have these
    int reference_spp = 4096;  ///< more than any method sweeps, whose noise would be as great
    int repeats = 3;           ///< warm runs of a point; no more start after kEnoughSeconds
    std::string gl;            ///< --gl of the program; empty: its default
    bool any_build = false;    ///< also use points that another build of the program completed
    std::string only_setting =
        {};  ///< value of the one point of each method to be measured; empty: all
    std::string shader_cache = "shader_cache";  ///< in the folder; no other process may use it
    bool quiet = false;                         ///< prints no progress
};

/// Who measures by these.
ChartHost hostOf(const ChartParams& params);

/// What the report puts into the chart's folder.
constexpr const char* kReportFiles[] = {"chart.html", "chart.csv", "chart.json"};

struct ChartPoint {
    std::string method;   ///< SweepMethod::name
    std::string setting;  ///< settingLabel()
    std::string file;     ///< its EXR, relative to the folder
    Measurement measured;
    Comparison errors;  ///< of the layer `indirect`; not judged: see Comparison::judged
    std::string image_png, heatmap_png;
};

struct ChartScene {
    std::string name;  ///< the file's stem; as given where two scenes share it
    std::string file;
    std::string camera;  ///< name
    std::string reference_file;
    double reference_seconds = 0;
    /// sqrt(mean variance) / mean of the reference: errors below are more its own noise than what
    /// is measured.
    double noise_rel_rmse = 0;
    std::string reference_png;
    std::vector<ChartPoint> points;  ///< by method, then from the fastest setting on
};

struct Chart {
    ChartHost host;
    int width = 0, height = 0;
    int bounces = 1;
    int reference_spp = 0;
    int repeats = 0;
    std::vector<SweepMethod> methods;
    std::vector<ChartScene> scenes;
    std::optional<Sequences> sequences = {};  ///< measured before, elsewhere
    std::optional<Bakes> bakes = {};          ///< likewise
};

/// Renders references and runs of points that the folder does not hold yet, then judges all points.
/// Prints a line for each run on stderr, with the time left. Usage error for a camera that a
/// scene has not or a scene given twice; input error for a scene that cannot be read or that shows
/// no indirect light; environment error where the folder cannot be written.
Chart measureChart(const ChartParams& params);

/// Fills in what `scene` says of its reference and its points' images: errors, and PNG images of
/// the layer `indirect`, all at the exposure of the reference. Files are found in `folder`.
/// Input error where the reference is black.
void judgeScene(const std::string& folder, ChartScene& scene);

/// Something to render: a reference or a point. Predicted and, once it has run, measured.
struct SweepJob {
    size_t scene = 0;
    size_t method = 0;    ///< any numbers that differ where methods do; references are one of them
    double cost = 1;      ///< as SweepSetting::cost
    double seconds = -1;  ///< of one run; negative: none has ended
    double spent = 0;     ///< seconds of all runs
    int repeats = 1;      ///< runs at most
    int runs = 0;         ///< that have ended; `repeats` where no more are wanted
};

/// Seconds that all runs left will take: of a job that has run, as long as it did; of others, from
/// how long those that have took against their costs: those of the same scene and method; where
/// there are none, the mean over the methods of that scene; else over all. Negative where no job
/// has run.
double secondsLeft(std::span<const SweepJob> jobs);

/// Indices of the points that no other beats, by growing time: none is as fast and as right, and
/// better in one of the two. Equal points are all kept; a point whose time or error is not a
/// positive finite number is not considered.
struct TimeAndError {
    double seconds = 0;
    double error = 0;
};
std::vector<size_t> paretoFront(std::span<const TimeAndError> points);

}  // namespace sheen
