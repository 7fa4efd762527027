// sheen animate: frames of a scene that moves, as images or a movie.
#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>

#include "cli/animate_frames.h"
#include "cli/commands.h"
#include "cli/movie.h"
#include "core/parallel.h"
#include "core/timer.h"

namespace sheen::cli {
namespace {

namespace fs = std::filesystem;

const std::map<std::string, TemporalGradients> kGradients = {
    {"extrapolated", TemporalGradients::kExtrapolated},
    {"interpolated", TemporalGradients::kInterpolated},
    {"none", TemporalGradients::kNone}};

struct AnimateOptions {
    RenderOptions render;
    std::string animation;
    std::string frames;
    double fps = 24.0;
    int lifespan = 0;  // of records; 0: each frame's are its own
    std::string gradients = "extrapolated";
    TemporalParams temporal;
    bool anchors = false;
    std::vector<CLI::Option*> of_lifespans;  // that mean nothing without
    CLI::App* app = nullptr;
};

struct Output {
    std::string movie = {};   // empty: images are what is wanted
    std::string ffmpeg = {};  // that makes it
    FrameFiles frames = {};
};

Output understandOutput(AnimateOptions& o, const Ranks& ranks) {
    RenderOptions& r = o.render;
    if (!r.cache.empty()) {
        throwUsage("--cache: not an option of animate, whose frames stand for themselves");
    }
    Output output;
    if (fs::path(r.output).extension() == ".mp4") {
        output.movie = r.output;
        output.ffmpeg = ranks.first() ? findFfmpeg(r.output) : "";  // who makes the movie
        output.frames.names = {.before = r.output + ".frames/", .after = ".png", .digits = 6};
        r.output = output.frames.names(0);
    } else if (!countsFrames(r.output)) {
        throwUsage("-o {}: must count frames, as in frame_%04d.exr or .png, or be a movie, .mp4",
                   r.output);
    } else {
        output.frames.names = parseFrameNames("-o", r.output);
    }
    output.frames.kind = understand(r);
    return output;
}

// Usage error where records cannot outlive a frame, as the option asks.
void checkRecordsLive(const char* option, const AnimateOptions& o, const Ranks& ranks) {
    const RenderParams& params = o.render.params;
    if (!usesCache(params.method) || params.gather_road != GatherRoad::kRays) {
        throwUsage("{}: only records live, of radiance and irradiance by --gather ray", option);
    }
    if (ranks.count() > 1) {
        throwUsage(
            "{}: each frame takes records of the one before, so that frames cannot be "
            "shared out over {} ranks; leave it out, or run without mpirun",
            option, ranks.count());
    }
}

// How records live; none: each frame has its own.
std::optional<TemporalParams> temporalOf(const AnimateOptions& o, const Ranks& ranks) {
    if (o.lifespan == 0) {
        for (const CLI::Option* option : o.of_lifespans) {
            if (option->count() > 0 && o.anchors) {
                throwUsage("{}: is of records with a lifespan, not of those that --anchors follows",
                           option->get_name());
            }
            if (option->count() > 0) {
                throwUsage("{}: needs --lifespan, since otherwise each frame has its own records",
                           option->get_name());
            }
        }
        return std::nullopt;
    }
    checkRecordsLive("--lifespan", o, ranks);
    const RenderParams& params = o.render.params;
    TemporalParams temporal = o.temporal;
    temporal.longest = o.lifespan;
    temporal.gradients = kGradients.at(o.gradients);
    if (temporal.gradients == TemporalGradients::kInterpolated &&
        (params.target_error > 0.0 || params.time_limit > 0.0)) {
        throwUsage(
            "--temporal-gradients interpolated: gathers records before it makes images, whose "
            "error or time it cannot know then; leave out --target-error and --time-limit");
    }
    return temporal;
}

FrameRange rangeOf(const AnimateOptions& o, const AnimatedScene& scene) {
    constexpr double kRounding = 1e-6;  // of times that were floats, frames
    constexpr double kMost = 1e6;
    if (!o.frames.empty()) {
        return parseFrames(o.frames);
    }
    const double last = std::floor(scene.seconds() * o.fps + kRounding);
    if (!(last >= 1.0) || last >= kMost) {
        throwUsage("{}: has no animation of two frames to a million; say which by --frames A..B",
                   o.render.scene);
    }
    return {0, static_cast<int>(last)};
}

Json reportJson(const AnimateOptions& o, const FrameRange& frames, const std::vector<Json>& reports,
                double seconds) {
    return {{"first", frames.first},
            {"last", frames.last},
            {"fps", o.fps},
            {"kept", frames.last - frames.first + 1 - static_cast<int>(reports.size())},
            {"seconds", seconds},
            {"frames", reports}};
}

void printReport(const Output& output, const FrameRange& frames, const std::vector<Json>& reports,
                 double seconds) {
    int same = 0, moved = 0;
    int64_t records = 0, gathered = 0;
    for (const Json& report : reports) {
        const bool is_same = report.at("changed") == "nothing";
        same += is_same ? 1 : 0;
        moved += report.at("changed") == "cameras" ? 1 : 0;
        if (!is_same) {
            const auto of_frame = report.at("records").get<int64_t>();
            records += of_frame;
            gathered += of_frame - report.at("records_reused").get<int64_t>() +
                        report.at("records_renewed").get<int64_t>();
        }
    }
    const int count = frames.last - frames.first + 1;
    const auto made = static_cast<int>(reports.size());
    fmt::print("frames    {} to {}: {} made, {} were there\n", frames.first, frames.last, made,
               count - made);
    fmt::print("changed   nothing before {} of them, only cameras before {}\n", same, moved);
    if (records > gathered) {
        fmt::print("records   {:.1f}% of them gathered anew, frame by frame\n",
                   100.0 * static_cast<double>(gathered) / static_cast<double>(records));
    }
    fmt::print("seconds   {:.3f}, {:.3f} a frame made\n", seconds, made > 0 ? seconds / made : 0.0);
    const FrameNames& names = output.frames.names;
    fmt::print("wrote     {}\n", output.movie.empty() ? fmt::format("{} to {}", names(frames.first),
                                                                    names(frames.last))
                                                      : output.movie);
}

void makeFolder(const FrameNames& names) {
    const fs::path folder = fs::path(names(0)).parent_path();
    std::error_code error;
    if (!folder.empty()) {
        fs::create_directories(folder, error);
    }
    if (error) {
        throwEnvironment("{}: cannot be made: {}", folder.string(), error.message());
    }
}

void removeFrames(const FrameNames& names) {
    std::error_code ignored;
    for (const int frame : framesThere(names)) {
        fs::remove(names(frame), ignored);
    }
    fs::remove(sequenceFile(names), ignored);
    fs::remove(fs::path(names(0)).parent_path(), ignored);  // unless other files are there
}

// What is known of the sequence that is begun or continued, and written beside it.
Sequence sequenceOf(const AnimateOptions& o, const Output& output, const FrameRange& frames,
                    const Scene& scene, const SequenceKey& key) {
    const FrameNames& names = output.frames.names;
    Sequence sequence = findSequence(names, frames, key).value_or(Sequence{.key = key});
    if (output.frames.kind == FileKind::kPng && !sequence.exposure) {
        sequence.exposure = parseExposure(o.render.exposure);
    }
    makeFolder(names);
    checkOutputs({{"-o", names(frames.first)},
                  {"-o", sequenceFile(names)},
                  {"-o", output.movie},
                  {"--json", o.render.json}},
                 scene.files);
    writeSequence(names, sequence);
    return sequence;
}

ExitCode runAnimate(AnimateOptions& o, Ranks& ranks) {
    const Timer total;
    const Output output = understandOutput(o, ranks);
    setThreadCount(o.render.threads > 0 ? o.render.threads : ranks.threads());
    const std::optional<TemporalParams> temporal = temporalOf(o, ranks);
    if (o.anchors) {
        if (temporal) {
            throwUsage("--anchors: records have no lifespan then; leave out --lifespan");
        }
        checkRecordsLive("--anchors", o, ranks);
    }
    if (!o.frames.empty()) {
        parseFrames(o.frames);  // before loading
    }
    AnimatedScene scene(o.render.scene, o.render.load, o.animation);
    for (const std::string& warning : scene.scene().warnings) {
        warn(warning);
    }
    const FrameRange frames = rangeOf(o, scene);
    const SequenceKey key = keyOf(*o.app, scene.scene());
    const std::string job = jobText(key, output.frames.names(0));
    const SequenceParams params{.part = o.render.part,
                                .fps = o.fps,
                                .temporal = temporal,
                                .anchors = o.anchors,
                                .last = frames.last};
    o.render.params.quiet = true;
    if (!ranks.first()) {
        FrameMaker(o.render, output.frames, scene, params, {.key = key}).serve(ranks, job);
        return ExitCode::kDone;
    }
    const Sequence sequence = sequenceOf(o, output, frames, scene.scene(), key);
    FrameMaker maker(o.render, output.frames, scene, params, sequence);
    const std::vector<Json> reports = maker.make(ranks, job, missingFrames(output.frames, frames));
    if (!output.movie.empty()) {
        writeMovie(output.ffmpeg, output.frames.names, frames, o.fps, output.movie);
        removeFrames(output.frames.names);
    }
    writeJson(o.render.json, reportJson(o, frames, reports, total.seconds()));
    if (wantsText(o.render.json)) {
        printReport(output, frames, reports, total.seconds());
    }
    return ExitCode::kDone;
}

}  // namespace

Command addAnimate(CLI::App& program, Ranks& ranks) {
    CLI::App* app = program.add_subcommand(
        "animate", "Render frames of a scene that moves, continuing where it was interrupted");
    const auto options = std::make_shared<AnimateOptions>();
    options->app = app;
    addRenderOptions(*app, options->render);
    app->get_option("--output")
        ->description(
            "Images to write, whose name counts frames: frame_%04d.exr or .png; or a movie, .mp4, "
            "by ffmpeg")
        ->required();
    app->add_option("--frames", options->frames,
                    "First and last frame; default: all of the animation")
        ->type_name("A..B")
        ->check(fileName());
    app->add_option("--fps", options->fps, "Frames a second; frame 0 is the animation's beginning")
        ->check(numberIn(0.001, 1000))
        ->capture_default_str();
    app->add_option("--lifespan", options->lifespan,
                    "radiance, irradiance: records stay in place and live for so many frames at "
                    "most, in which something moves (temporal radiance caching), 1..1000; 0: each "
                    "frame has its own")
        ->check(numberIn(0, 1000))
        ->capture_default_str();
    options->of_lifespans = {
        app->add_option("--temporal-accuracy", options->temporal.accuracy,
                        "By how much of itself a record's light may change while it lives, as "
                        "foreseen")
            ->check(numberIn(0.001, 10))
            ->capture_default_str(),
        app->add_option("--temporal-gradients", options->gradients,
                        "What a record says while it lives: goes on changing as foreseen "
                        "(extrapolated), changes evenly to what is found at its end, for which "
                        "records are gathered frames ahead of images (interpolated), or stays "
                        "(none)")
            ->check(CLI::IsMember({"extrapolated", "interpolated", "none"}))
            ->capture_default_str()};
    app->add_flag("--anchors", options->anchors,
                  "radiance, irradiance: records stay in place and keep what their rays met; the "
                  "light there is found anew in every frame, and rays only where something moves");
    app->add_option("--animation", options->animation,
                    "Name or number of an animation; default: the file's first")
        ->type_name("NAME");
    return {app, [options, &ranks] { return runAnimate(*options, ranks); }};
}

}  // namespace sheen::cli
