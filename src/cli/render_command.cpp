// sheen render: one frame of a scene into an EXR or PNG file.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>
#include <memory>

#include "cli/commands.h"
#include "cli/options.h"
#include "cli/output.h"
#include "core/parallel.h"
#include "core/timer.h"
#include "image/exr.h"
#include "image/png.h"
#include "render/black_frame.h"
#include "render/render.h"

namespace sheen::cli {
namespace {

const std::map<std::string, Method> kMethods = {{"radiance", Method::kRadiance},
                                                {"irradiance", Method::kIrradiance},
                                                {"reference", Method::kReference},
                                                {"octree", Method::kOctree},
                                                {"denoised", Method::kDenoised}};

const std::map<std::string, ToneCurve> kTones = {{"neutral", ToneCurve::kNeutral},
                                                 {"none", ToneCurve::kNone}};

struct Gather {
    GatherRoad road;
    HemisphereKind hemisphere;
};
const std::map<std::string, Gather> kGathers = {
    {"ray", {GatherRoad::kRays, HemisphereKind::kHemicube}},
    {"border", {GatherRoad::kRaster, HemisphereKind::kBorder}},
    {"plane", {GatherRoad::kRaster, HemisphereKind::kPlane}},
    {"larsen", {GatherRoad::kRaster, HemisphereKind::kLarsen}},
    {"hemicube", {GatherRoad::kRaster, HemisphereKind::kHemicube}}};

// An option that only some methods understand.
struct LimitedOption {
    CLI::Option* option = nullptr;
    std::vector<Method> methods;
};

struct RenderOptions {
    std::string scene;
    std::string output;
    std::string size = "512x512";
    std::string method = "radiance";
    std::string sh_order = "auto";
    std::string gather = "ray";
    std::string bounces = "all";
    std::string exposure = "auto";
    std::string tone = "neutral";
    std::string layers = "basic";
    std::string json;
    int threads = 0;
    LoadParams load;
    std::string camera_at;
    std::string look_at;
    double fov = 0.0;  // degrees; 0: the camera's
    RenderParams params;
    std::vector<LimitedOption> limited;
    CLI::Option* aa_option = nullptr;
    CLI::Option* exposure_option = nullptr;
    CLI::Option* tone_option = nullptr;
    CLI::Option* layers_option = nullptr;
    CLI::Option* extent_option = nullptr;
    CLI::Option* bounces_option = nullptr;
};

template <class T>
std::vector<std::string> keysOf(const std::map<std::string, T>& map) {
    std::vector<std::string> keys;
    for (const auto& [key, value] : map) {
        keys.push_back(key);
    }
    return keys;
}

void addImageOptions(CLI::App& app, RenderOptions& o) {
    app.add_option("SCENE", o.scene, "glTF scene, .glb or .gltf")
        ->type_name("FILE")
        ->required()
        ->check(fileName());
    app.add_option("-o,--output", o.output,
                   "Image to write, .exr (all figures) or .png (to look at); "
                   "default: the scene's name with .exr, in the current folder")
        ->type_name("FILE")
        ->check(fileName());
    app.add_option("--size", o.size, "Width x height in pixels, each 1..16384")
        ->capture_default_str();
    app.add_option("--camera", o.params.camera, "Name or number of a camera; default: the first");
    app.add_option("--camera-at", o.camera_at,
                   "Where to see the scene from, in the file's coordinates")
        ->type_name("X,Y,Z")
        ->check(fileName());
    app.add_option("--look-at", o.look_at,
                   "A point to look at; with --camera-at, default: the scene's middle")
        ->type_name("X,Y,Z")
        ->check(fileName());
    app.add_option("--fov", o.fov, "Vertical field of view, degrees; default: the camera's")
        ->check(numberIn(0.1, 179));
    app.add_option("--variant", o.load.variant, "Materials by a name of KHR_materials_variants");
    addEnvironmentOptions(app, o.load.environment);
    o.exposure_option =
        app.add_option("--exposure", o.exposure,
                       "PNG only: stops, or auto: the log-average becomes middle grey")
            ->capture_default_str();
    o.tone_option =
        app.add_option("--tone", o.tone,
                       "PNG only: tone curve, neutral (Khronos PBR Neutral: colours as materials "
                       "state them, highlights compressed) or none (clipped)")
            ->check(CLI::IsMember(keysOf(kTones)))
            ->capture_default_str();
    o.aa_option = app.add_option("--aa", o.params.aa,
                                 fmt::format("Samples of a pixel through which an edge passes; 1: "
                                             "each pixel shows its middle. More than 1: radiance "
                                             "and irradiance by rays, whose default is {}, and "
                                             "reference, which then sees whole pixels",
                                             kSmoothEdges))
                      ->check(CLI::IsMember({1, 2, 4, 8, 16, 32, 64}))
                      ->type_name("N")
                      ->default_str("");
    o.layers_option = app.add_option("--layers", o.layers,
                                     "EXR only: basic (beauty, direct, indirect) or all "
                                     "(also normals, depth, record weights, ...)")
                          ->check(CLI::IsMember({"basic", "all"}))
                          ->capture_default_str();
}

void addMethodOptions(CLI::App& app, RenderOptions& o) {
    const std::vector<Method> cached = {Method::kRadiance, Method::kIrradiance};
    const std::vector<Method> any_cache = {Method::kRadiance, Method::kIrradiance, Method::kOctree};
    const std::vector<Method> traced = {Method::kReference, Method::kDenoised};
    RenderParams& p = o.params;
    app.add_option("--method", o.method,
                   "radiance (cache, glossy and diffuse), irradiance (cache, diffuse only), "
                   "reference (path tracer), or to compare with: denoised (path tracer, filtered), "
                   "octree (classical irradiance cache, diffuse only)")
        ->check(CLI::IsMember(keysOf(kMethods)))
        ->capture_default_str();
    const auto limited = [&o](CLI::Option* option, std::vector<Method> methods) {
        option->capture_default_str();
        o.limited.push_back({option, std::move(methods)});
        return option;
    };
    CLI::Option* accuracy = limited(
        app.add_option("--accuracy", p.placement.accuracy,
                       "radiance, irradiance, octree: largest error of a record's reuse, smaller "
                       "is better and slower")
            ->check(numberIn(0.01, 2)),
        any_cache);
    limited(app.add_option("--target-error", p.target_error,
                           "radiance, irradiance: render again at finer accuracies until the "
                           "estimated relative error of the indirect light, at the upper end of "
                           "its interval, is at "
                           "most this, "
                           "0.002..0.5")
                ->check(numberIn(0.002, 0.5))
                ->excludes(accuracy)
                ->default_str(""),
            cached);
    limited(app.add_option("--time-limit", p.time_limit,
                           "radiance, irradiance: render again at finer accuracies as long as "
                           "that fits into so many seconds of wall time, loading and writing "
                           "included, 0.1..86400; the image then depends on the machine")
                ->check(numberIn(0.1, 86400))
                ->excludes(accuracy)
                ->excludes("--target-error")
                ->default_str(""),
            cached);
    limited(app.add_option("--sh-order", o.sh_order,
                           "radiance: order of the spherical harmonics, 2..10, or auto: by "
                           "material"),
            {Method::kRadiance});
    limited(app.add_option("--gather", o.gather,
                           "radiance, irradiance: how a record sees its hemisphere: by rays "
                           "through a hemicube (ray), or rasterised: on a hemicube, or one plane "
                           "with its border stretched to the horizon (border), bare (plane) or "
                           "rescaled (larsen)")
                ->check(CLI::IsMember(keysOf(kGathers))),
            cached);
    limited(
        app.add_option(
               "--gather-size", p.gather.size,
               fmt::format(
                   "radiance, irradiance: texels along a side of that plane ({} at the "
                   "default accuracy, rasterised {}, border {}), by rays that of a record which "
                   "reaches 5 pixels, farther reaching ones having more; octree: rings "
                   "of a record's rays; default: by the accuracy",
                   gatherSize(GatherRoad::kRays, p.placement.accuracy),
                   gatherSize(GatherRoad::kRaster, p.placement.accuracy),
                   gatherSize(GatherRoad::kRaster, p.placement.accuracy, HemisphereKind::kBorder)))
            ->check(numberIn(8, 512)),
        any_cache)
        ->default_str("");
    o.extent_option =
        limited(app.add_option("--gather-extent", p.gather.extent,
                               "radiance, irradiance: half-width of that plane at "
                               "distance 1 (border 2.5, others 3); not for a hemicube")
                    ->check(numberIn(1, 10)),
                cached)
            ->default_str("");
    o.bounces_option =
        app.add_option("--bounces", o.bounces,
                       "Bounces of indirect light: all, or so many at the most, 1..64; the octree "
                       "and records that are rasterised have 1")
            ->capture_default_str();
    limited(app.add_option("--spp", p.spp, "reference, denoised: paths a pixel")
                ->check(numberIn(1, 65536)),
            traced);
    limited(app.add_option("--seed", p.seed, "reference, denoised: seed of their random numbers")
                ->check(numberIn(0, std::numeric_limits<uint32_t>::max())),
            traced);
}

void addProgramOptions(CLI::App& app, RenderOptions& o) {
    app.add_option("--threads", o.threads, "Threads to use; 0: one a hardware thread")
        ->check(numberIn(0, 256))
        ->capture_default_str();
    app.add_option("--json", o.json, "File for all figures as JSON; -: standard output")
        ->type_name("FILE")
        ->check(fileName());
}

// Of a time limit: what writing may take, and ending.
constexpr double kWriteShare = 0.03;

bool tracesPaths(Method method) {
    return method == Method::kReference || method == Method::kDenoised;
}

bool usesCache(Method method) {
    return method == Method::kRadiance || method == Method::kIrradiance;
}

void checkMethodOptions(const RenderOptions& o) {
    for (const LimitedOption& limited : o.limited) {
        const auto& methods = limited.methods;
        if (limited.option->count() > 0 &&
            std::find(methods.begin(), methods.end(), o.params.method) == methods.end()) {
            throwUsage("{}: not an option of --method {}", limited.option->get_name(), o.method);
        }
    }
    if (o.params.gather.kind == HemisphereKind::kHemicube && o.extent_option->count() > 0) {
        throwUsage("--gather-extent: not an option of --gather {}", o.gather);
    }
}

// All, unless something else is asked for or the method has one.
int bouncesOf(const RenderOptions& o) {
    const bool rasterised = o.params.gather_road == GatherRoad::kRaster;
    const bool one = rasterised || o.params.method == Method::kOctree;
    if (one && o.bounces_option->count() == 0) {
        return 1;
    }
    const int bounces = parseBounces(o.bounces);
    if (one && bounces != 1) {
        throwUsage("--bounces {}: {} computes one", o.bounces,
                   rasterised ? "--gather " + o.gather : "--method " + o.method);
    }
    return bounces;
}

void checkFileOptions(const RenderOptions& o, FileKind kind) {
    for (const CLI::Option* option : {o.exposure_option, o.tone_option}) {
        if (kind == FileKind::kExr && option->count() > 0) {
            throwUsage("{}: for PNG only; {} stores radiance as it is", option->get_name(),
                       o.output);
        }
    }
    if (kind == FileKind::kPng && o.layers_option->count() > 0) {
        throwUsage("--layers: for EXR only; {} holds one image", o.output);
    }
}

std::string defaultOutput(const std::string& scene) {
    return std::filesystem::path(scene).stem().string() + ".exr";
}

// Materials may share a name; keys of an object may not.
Json shOrders(const std::vector<MaterialOrder>& orders) {
    Json json = Json::object();
    for (size_t i = 0; i < orders.size(); ++i) {
        const std::string& name = orders[i].material;
        json[json.contains(name) ? fmt::format("{} #{}", name, i) : name] = orders[i].order;
    }
    return json;
}

// Stages in the order they run.
std::vector<std::pair<const char*, double>> stagesOf(const StageSeconds& s) {
    return {{"load", s.load},       {"gbuffer", s.gbuffer},     {"shadow", s.shadow},
            {"bounces", s.bounces}, {"placement", s.placement}, {"gather", s.gather},
            {"project", s.project}, {"splat", s.splat},         {"compose", s.compose},
            {"trace", s.trace},     {"denoise", s.denoise},     {"write", s.write}};
}

Json statsJson(const RenderOptions& o, const RenderStats& stats) {
    Json seconds = {{"total", stats.seconds.total}};
    for (const auto& [stage, value] : stagesOf(stats.seconds)) {
        seconds[stage] = value;
    }
    Json json = {{"method", o.method},
                 {"size", {o.params.width, o.params.height}},
                 {"threads", threadCount()},
                 {"output", o.output},
                 {"records", stats.records},
                 {"seconds", seconds},
                 {"pixels_geometry", stats.pixels_geometry},
                 {"pixels_uncovered", stats.pixels_uncovered},
                 {"nonfinite_pixels", stats.nonfinite_pixels},
                 {"negative_pixels", stats.negative_pixels},
                 {"estimated_rel_rmse", stats.estimated_rel_rmse},
                 {"estimate_low", stats.estimate_low},
                 {"estimate_high", stats.estimate_high},
                 {"accuracy", stats.accuracy},
                 {"gather_size", stats.gather_size},
                 {"passes", stats.passes},
                 {"diffuse_share", stats.diffuse_share},
                 {"corrected_share", stats.corrected_share},
                 {"too_glossy_share", stats.too_glossy_share},
                 {"aa", o.params.aa},
                 {"pixels_edges", stats.pixels_edges},
                 {"edge_records", stats.edge_records},
                 {"sh_order", shOrders(stats.sh_order)},
                 {"gl_renderer", stats.gl_renderer}};
    if (usesCache(o.params.method)) {
        json["gather"] = o.gather;
        json["elements"] = stats.elements;
        json["elements_missed_share"] = stats.elements_missed_share;
    }
    if (tracesPaths(o.params.method)) {
        json["mrays_per_second"] = stats.mrays_per_second;
        json["spp"] = stats.spp;
    }
    return json;
}

std::string orderSummary(const std::vector<MaterialOrder>& orders) {
    std::map<int, int> materials_of;
    for (const MaterialOrder& material : orders) {
        ++materials_of[material.order];
    }
    std::string text;
    for (const auto& [order, count] : materials_of) {
        text += fmt::format("{}{} x{}", text.empty() ? "" : ", ",
                            order == 0 ? "diffuse" : fmt::format("order {}", order), count);
    }
    return text;
}

void printStats(const RenderOptions& o, const RenderStats& stats) {
    std::string stages;
    for (const auto& [stage, value] : stagesOf(stats.seconds)) {
        if (value > 0.0) {
            stages += fmt::format("{}{} {:.3f}", stages.empty() ? "" : ", ", stage, value);
        }
    }
    fmt::print("seconds   {:.3f}: {}\n", stats.seconds.total, stages);
    if (tracesPaths(o.params.method)) {
        fmt::print("rays      {:.2f} million a second, {} threads; {} paths a pixel\n",
                   stats.mrays_per_second, threadCount(), stats.spp);
    } else {
        fmt::print("records   {}; pixels without one: {} of {}\n", stats.records,
                   stats.pixels_uncovered, stats.pixels_geometry);
    }
    if (usesCache(o.params.method)) {
        fmt::print("gather    {}\n", o.gather);
        if (stats.elements > 0) {
            fmt::print(
                "bounces   {}: kept at {} elements, none near for {:.2g}% of what asks them\n",
                o.bounces, stats.elements, 100.0 * stats.elements_missed_share);
        }
        if (std::isfinite(stats.estimated_rel_rmse)) {
            fmt::print("estimate  rel_rmse of the indirect light {:.1f}% ({:.1f} to {:.1f}%)\n",
                       100 * stats.estimated_rel_rmse, 100 * stats.estimate_low,
                       100 * stats.estimate_high);
        } else {
            fmt::print("estimate  none: no indirect light is seen\n");
        }
        if (o.params.target_error > 0.0 || o.params.time_limit > 0.0) {
            fmt::print("accuracy  {:.3g}, found in {} passes\n", stats.accuracy, stats.passes);
        }
        fmt::print(
            "pixels    diffuse {:.1f}%, corrected by rays {:.1f}%, too glossy for the cache "
            "{:.1f}%\n",
            100.0 * stats.diffuse_share, 100.0 * stats.corrected_share,
            100.0 * stats.too_glossy_share);
        if (o.params.aa > 1) {
            fmt::print("edges     {} pixels of {} samples; {} records for what no pixel sees\n",
                       stats.pixels_edges, o.params.aa, stats.edge_records);
        }
        fmt::print("materials {}\n", orderSummary(stats.sh_order));
        fmt::print("renderer  {}, {} threads\n", stats.gl_renderer, threadCount());
    }
    if (stats.negative_pixels > 0) {
        fmt::print("clamped   {} negative pixels\n", stats.negative_pixels);
    }
    fmt::print("wrote     {} ({}x{}, {})\n", o.output, o.params.width, o.params.height, o.method);
}

void writeFrame(const RenderOptions& o, FileKind kind, const Frame& frame) {
    if (kind == FileKind::kPng) {
        writePng(o.output, frame, parseExposure(o.exposure), kTones.at(o.tone));
    } else {
        writeExr(o.output, frame, o.params.all_layers ? ExrLayers::kAll : ExrLayers::kBasic);
    }
}

void parseView(RenderOptions& o) {
    Viewpoint& view = o.load.view;
    if (!o.camera_at.empty()) {
        view.at = parsePoint("--camera-at", o.camera_at);
    }
    if (!o.look_at.empty()) {
        view.look_at = parsePoint("--look-at", o.look_at);
    }
    if (o.fov > 0.0) {
        view.y_fov = static_cast<float>(glm::radians(o.fov));
    }
    o.load.camera = o.params.camera;
    if (view.given()) {
        o.params.camera.clear();  // it becomes the first
    }
}

ExitCode runRender(RenderOptions& o) {
    const Timer total;
    const ivec2 size = parseSize(o.size);
    o.params.width = size.x;
    o.params.height = size.y;
    o.params.method = kMethods.at(o.method);
    o.params.gather_road = kGathers.at(o.gather).road;
    o.params.gather.kind = kGathers.at(o.gather).hemisphere;
    o.params.sh_order = parseShOrder(o.sh_order);
    o.params.bounces = bouncesOf(o);
    o.params.all_layers = o.layers == "all";
    if (o.aa_option->count() == 0 && smoothsEdges(o.params.method, o.params.gather_road)) {
        o.params.aa = kSmoothEdges;
    }
    parseExposure(o.exposure);
    parseView(o);
    checkMethodOptions(o);
    o.output = o.output.empty() ? defaultOutput(o.scene) : o.output;
    const FileKind kind = imageKind(o.output);
    checkFileOptions(o, kind);
    setThreadCount(o.threads);

    o.load.environment.no_sky =
        usesCache(o.params.method) && o.params.gather_road == GatherRoad::kRaster;
    const Timer load;
    const Scene scene = loadScene(o.scene, o.load);
    for (const std::string& warning : scene.warnings) {
        warn(warning);
    }
    const double load_seconds = load.seconds();
    checkOutputs({{"-o", o.output}, {"--json", o.json}}, scene.files);

    const double limit = o.params.time_limit;
    if (limit > 0.0) {
        // Above 0, which would be no limit.
        constexpr double kLeast = 1e-3;
        o.params.time_limit = std::max(limit - total.seconds() - kWriteShare * limit, kLeast);
    }
    RenderResult result = renderFrame(scene, o.params);
    const Timer write;
    writeFrame(o, kind, result.frame);
    result.stats.seconds.write = write.seconds();
    result.stats.seconds.load = load_seconds;
    result.stats.seconds.total = total.seconds();
    if (result.stats.nonfinite_pixels > 0) {
        warn(fmt::format("{}: {} pixels are not finite", o.output, result.stats.nonfinite_pixels));
    }
    const std::string black = whyBlack(scene, findCamera(scene, o.params.camera), result.frame);
    if (!black.empty()) {
        warn(fmt::format("{}: {}", o.scene, black));
    }
    if (o.params.target_error > 0.0 && result.stats.estimate_high > o.params.target_error) {
        const bool finest = result.stats.accuracy <= kFinestAccuracy;
        warn(fmt::format(
            "--target-error {}: the estimate's upper end stays at {:.3g} and {}",
            o.params.target_error, result.stats.estimate_high,
            finest ? "there are no finer records" : "finer records would not lower it by much"));
    }
    if (limit > 0.0 && result.stats.seconds.total > limit) {
        warn(fmt::format("--time-limit {}: the image took {:.3g} s, at accuracy {:.3g}", limit,
                         result.stats.seconds.total, result.stats.accuracy));
    }
    writeJson(o.json, statsJson(o, result.stats));
    if (wantsText(o.json)) {
        printStats(o, result.stats);
    }
    return ExitCode::kDone;
}

}  // namespace

Command addRender(CLI::App& program) {
    CLI::App* app = program.add_subcommand("render", "Render one frame of a scene");
    const auto options = std::make_shared<RenderOptions>();
    addImageOptions(*app, *options);
    addMethodOptions(*app, *options);
    addProgramOptions(*app, *options);
    return {app, [options] { return runRender(*options); }};
}

}  // namespace sheen::cli
