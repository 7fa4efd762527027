// sheen animate: frames of a scene that moves, as images or a movie.
#include <fmt/format.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>
#include <optional>

#include "chart/point_file.h"
#include "cli/commands.h"
#include "cli/movie.h"
#include "cli/render_report.h"
#include "cli/sequence_file.h"
#include "core/parallel.h"
#include "core/progress.h"
#include "core/timer.h"
#include "image/decode.h"
#include "image/exr.h"
#include "image/png.h"
#include "render/animation.h"

namespace sheen::cli {
namespace {

namespace fs = std::filesystem;

struct AnimateOptions {
    RenderOptions render;
    std::string animation;
    std::string frames;
    double fps = 24.0;
    int lifespan = 0;  // of records; 0: each frame's are its own
    std::string gradients = "extrapolated";
    TemporalParams temporal;
    std::vector<CLI::Option*> of_lifespans;  // that mean nothing without
    CLI::App* app = nullptr;
};

// Where frames go.
struct Output {
    std::string movie = {};   // empty: images are what is wanted
    std::string ffmpeg = {};  // that makes it
    FrameNames names = {};
    FileKind kind = FileKind::kExr;
};

Output understandOutput(AnimateOptions& o) {
    RenderOptions& r = o.render;
    if (!r.cache.empty()) {
        throwUsage("--cache: not an option of animate, whose frames stand for themselves");
    }
    Output output;
    if (fs::path(r.output).extension() == ".mp4") {
        output.movie = r.output;
        output.ffmpeg = findFfmpeg(r.output);
        output.names = {.before = r.output + ".frames/", .after = ".png", .digits = 6};
        r.output = output.names(0);
    } else if (!countsFrames(r.output)) {
        throwUsage("-o {}: must count frames, as in frame_%04d.exr or .png, or be a movie, .mp4",
                   r.output);
    } else {
        output.names = parseFrameNames("-o", r.output);
    }
    output.kind = understand(r);
    return output;
}

// How records live; none: each frame has its own.
std::optional<TemporalParams> temporalOf(const AnimateOptions& o) {
    if (o.lifespan == 0) {
        for (const CLI::Option* option : o.of_lifespans) {
            if (option->count() > 0) {
                throwUsage("{}: needs --lifespan, since otherwise each frame has its own records",
                           option->get_name());
            }
        }
        return std::nullopt;
    }
    const RenderParams& params = o.render.params;
    if (!usesCache(params.method) || params.gather_road != GatherRoad::kRays) {
        throwUsage("--lifespan: only records live, of radiance and irradiance by --gather ray");
    }
    TemporalParams temporal = o.temporal;
    temporal.longest = o.lifespan;
    temporal.extrapolate = o.gradients == "extrapolated";
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

// What of the options changes images, as they were given.
std::string optionsText(const CLI::App& app) {
    std::string text;
    for (const CLI::Option* option : app.get_options()) {
        const std::string name = option->get_name();
        const bool of_images = name != "SCENE" && name != "--output" && name != "--frames" &&
                               name != "--threads" && name != "--json";
        if (option->count() > 0 && of_images) {
            text += fmt::format("{}{}={}", text.empty() ? "" : " ", name,
                                fmt::join(option->results(), ","));
        }
    }
    return text;
}

SequenceKey keyOf(const AnimateOptions& o, const Scene& scene) {
    std::string files;
    for (const std::string& file : scene.files) {
        files += fileHash(file);
    }
    return {.program = "sheen " SHEEN_VERSION, .scene = files, .options = optionsText(*o.app)};
}

// Whether a frame is there, and can be read to its end.
bool isWhole(const std::string& path, FileKind kind) {
    if (!fs::exists(path)) {
        return false;
    }
    try {
        if (kind == FileKind::kExr) {
            readExr(path);
        } else {
            std::ifstream in(path, std::ios::binary);
            const std::vector<char> bytes{std::istreambuf_iterator<char>(in),
                                          std::istreambuf_iterator<char>()};
            decodeImage({reinterpret_cast<const uint8_t*>(bytes.data()), bytes.size()});
        }
        return true;
    } catch (const std::runtime_error& error) {  // of either reader
        warn(fmt::format("{}: rendered again: {}", path, error.what()));
        return false;
    }
}

struct FrameReport {
    int frame = 0;
    SceneChange change = SceneChange::kScene;
    RenderStats stats;
};

const char* nameOf(SceneChange change) {
    switch (change) {
        case SceneChange::kNothing:
            return "nothing";
        case SceneChange::kCameras:
            return "cameras";
        case SceneChange::kScene:
            return "scene";
    }
    throw std::logic_error("unknown change");
}

// Says each warning once.
class Warnings {
  public:
    void sayNew(const std::vector<std::string>& warnings) {
        for (; said_ < warnings.size(); ++said_) {
            warn(warnings[said_]);
        }
    }

  private:
    size_t said_ = 0;
};

// Brightness must not change from frame to frame by itself: the first frame's is that of all.
void fixExposure(const AnimateOptions& o, const Output& output, const Frame& frame,
                 Sequence& sequence) {
    if (output.kind == FileKind::kPng && !sequence.exposure) {
        sequence.exposure = parseExposure(o.render.exposure).value_or(autoExposure(beauty(frame)));
        writeSequence(output.names, sequence);
    }
}

void writeFrame(const AnimateOptions& o, const Output& output, const Sequence& sequence, int number,
                const Frame& frame) {
    const std::string path = output.names(number);
    if (output.kind == FileKind::kPng) {
        writePng(path, frame, sequence.exposure, o.render.to_display);
    } else {
        writeExr(path, frame, o.render.params.all_layers ? ExrLayers::kAll : ExrLayers::kBasic);
    }
}

std::vector<int> missingFrames(const Output& output, const FrameRange& frames) {
    std::vector<int> missing;
    for (int frame = frames.first; frame <= frames.last; ++frame) {
        if (!isWhole(output.names(frame), output.kind)) {
            missing.push_back(frame);
        }
    }
    return missing;
}

std::vector<FrameReport> renderFrames(AnimateOptions& o, const Output& output,
                                      const std::vector<int>& frames, AnimatedScene& scene,
                                      Warnings& warnings, Sequence& sequence) {
    RenderOptions& r = o.render;
    const double limit = r.params.time_limit;
    FrameSequence renderer(scene, r.params,
                           {.part = r.part, .fps = o.fps, .temporal = temporalOf(o)});
    Progress progress("frames", static_cast<int64_t>(frames.size()));
    std::vector<FrameReport> reports;
    for (const int frame : frames) {
        const RenderResult& result = renderer.render(frame);
        warnings.sayNew(scene.scene().warnings);
        fixExposure(o, output, result.frame, sequence);
        writeFrame(o, output, sequence, frame, result.frame);
        if (renderer.change() != SceneChange::kNothing) {
            r.output = output.names(frame);
            warnOf(r, scene.scene(), result, limit);
        }
        reports.push_back({frame, renderer.change(), result.stats});
        progress.advance();
    }
    return reports;
}

Json reportJson(const AnimateOptions& o, const Output& output, const FrameRange& frames,
                const std::vector<FrameReport>& reports, double seconds) {
    Json list = Json::array();
    for (const FrameReport& report : reports) {
        RenderOptions of_frame = o.render;
        of_frame.output = output.names(report.frame);
        Json json = {{"frame", report.frame}, {"changed", nameOf(report.change)}};
        json.update(statsJson(of_frame, report.stats));
        list.push_back(json);
    }
    return {{"first", frames.first},
            {"last", frames.last},
            {"fps", o.fps},
            {"kept", frames.last - frames.first + 1 - static_cast<int>(reports.size())},
            {"seconds", seconds},
            {"frames", list}};
}

void printReport(const Output& output, const FrameRange& frames,
                 const std::vector<FrameReport>& reports, double seconds) {
    int same = 0, moved = 0;
    int64_t records = 0, gathered = 0;
    for (const FrameReport& report : reports) {
        same += report.change == SceneChange::kNothing ? 1 : 0;
        moved += report.change == SceneChange::kCameras ? 1 : 0;
        const RenderStats& stats = report.stats;
        if (report.change != SceneChange::kNothing) {
            records += stats.records;
            gathered += stats.records - stats.records_reused + stats.records_renewed;
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
    fmt::print("wrote     {}\n",
               output.movie.empty()
                   ? fmt::format("{} to {}", output.names(frames.first), output.names(frames.last))
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

ExitCode runAnimate(AnimateOptions& o) {
    const Timer total;
    const Output output = understandOutput(o);
    setThreadCount(o.render.threads);
    temporalOf(o);
    if (!o.frames.empty()) {
        parseFrames(o.frames);  // before loading
    }
    AnimatedScene scene(o.render.scene, o.render.load, o.animation);
    Warnings warnings;
    warnings.sayNew(scene.scene().warnings);
    const FrameRange frames = rangeOf(o, scene);
    Sequence sequence{.key = keyOf(o, scene.scene())};
    if (const auto begun = findSequence(output.names, frames, sequence.key)) {
        sequence = *begun;
    }
    makeFolder(output.names);
    checkOutputs({{"-o", output.names(frames.first)},
                  {"-o", sequenceFile(output.names)},
                  {"-o", output.movie},
                  {"--json", o.render.json}},
                 scene.scene().files);
    writeSequence(output.names, sequence);
    o.render.params.quiet = true;
    const std::vector<FrameReport> reports =
        renderFrames(o, output, missingFrames(output, frames), scene, warnings, sequence);
    if (!output.movie.empty()) {
        writeMovie(output.ffmpeg, output.names, frames, o.fps, output.movie);
        removeFrames(output.names);
    }
    writeJson(o.render.json, reportJson(o, output, frames, reports, total.seconds()));
    if (wantsText(o.render.json)) {
        printReport(output, frames, reports, total.seconds());
    }
    return ExitCode::kDone;
}

}  // namespace

Command addAnimate(CLI::App& program) {
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
                        "(extrapolated), or stays (none)")
            ->check(CLI::IsMember({"extrapolated", "none"}))
            ->capture_default_str()};
    app->add_option("--animation", options->animation,
                    "Name or number of an animation; default: the file's first")
        ->type_name("NAME");
    return {app, [options] { return runAnimate(*options); }};
}

}  // namespace sheen::cli
