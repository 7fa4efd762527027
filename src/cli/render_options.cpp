#include "cli/render_options.h"

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <limits>
#include <map>
#include <sstream>

#include "core/error.h"
#include "image/color_view.h"

namespace sheen::cli {
namespace {

const std::map<std::string, Method> kMethods = {
    {"radiance", Method::kRadiance},   {"irradiance", Method::kIrradiance},
    {"reference", Method::kReference}, {"octree", Method::kOctree},
    {"denoised", Method::kDenoised},   {"hints", Method::kHints},
    {"lightmap", Method::kLightmap}};

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

const std::map<std::string, SitesBy> kPlacements = {{"scan", SitesBy::kScan},
                                                    {"kmeans", SitesBy::kKMeans}};

const std::map<std::string, KeptBy> kKeepers = {{"elements", KeptBy::kElements},
                                                {"photons", KeptBy::kPhotons}};

template <class T>
std::vector<std::string> keysOf(const std::map<std::string, T>& map) {
    std::vector<std::string> keys;
    for (const auto& [key, value] : map) {
        keys.push_back(key);
    }
    return keys;
}

void addImageOptions(CLI::App& app, RenderOptions& o) {
    addSceneOption(app, o.scene);
    app.add_option("-o,--output", o.output,
                   "Image to write, .exr (all figures) or .png (to look at); "
                   "default: the scene's name with .exr, in the current folder")
        ->type_name("FILE")
        ->check(fileName());
    app.add_option("--size", o.size, "Width x height in pixels, each 1..16384")
        ->capture_default_str();
    app.add_option("--crop", o.crop,
                   "Only a part of the image: its first column and row, from 0 on, its width and "
                   "its height in pixels")
        ->type_name("X,Y,W,H")
        ->check(fileName());
    addViewpointOptions(app, o.params.camera, o.camera_at, o.look_at, o.fov);
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
    o.view_option = app.add_option("--view", o.view,
                                   "PNG only: instead of these, a view of an OpenColorIO "
                                   "configuration, VIEW of its default display or DISPLAY/VIEW")
                        ->type_name("VIEW")
                        ->check(fileName())
                        ->excludes(o.tone_option);
    app.add_option("--ocio", o.ocio, "That configuration; default: what OCIO names")
        ->envname("OCIO")
        ->type_name("FILE")
        ->check(fileName());
    o.aa_option =
        app.add_option("--aa", o.params.aa,
                       fmt::format("Samples of a pixel through which an edge passes; 1: "
                                   "each pixel shows its middle. Default: {} for radiance "
                                   "and irradiance by rays and for reference, which then "
                                   "sees whole pixels; 1 for all else, which have no "
                                   "other",
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

const std::vector<Method> kCached = {Method::kRadiance, Method::kIrradiance};
const std::vector<Method> kAnyCache = {Method::kRadiance, Method::kIrradiance, Method::kOctree};
const std::vector<Method> kTraced = {Method::kReference, Method::kDenoised};

// Notes that an option is of these methods alone.
struct Limiter {
    RenderOptions& o;

    CLI::Option* operator()(CLI::Option* option, std::vector<Method> methods) const {
        option->capture_default_str();
        o.limited.push_back({option, std::move(methods)});
        return option;
    }
};

void addMethodOptions(CLI::App& app, RenderOptions& o) {
    RenderParams& p = o.params;
    const Limiter limited{o};
    o.method_option =
        app.add_option(
               "--method", o.method,
               "radiance (cache, glossy and diffuse), irradiance (cache, diffuse only), "
               "reference (path tracer), lightmap (diffuse light as the file's lightmaps have it), "
               "or to compare with: denoised (path tracer, filtered), octree (classical irradiance "
               "cache, diffuse only), hints (radiance hints: quick and approximate). sheen "
               "render's "
               "default is lightmap where the file has lightmaps for all its surfaces")
            ->check(CLI::IsMember(keysOf(kMethods)))
            ->capture_default_str();
    CLI::Option* accuracy = limited(
        app.add_option("--accuracy", p.placement.accuracy,
                       "radiance, irradiance, octree: largest error of a record's reuse, smaller "
                       "is better and slower")
            ->check(numberIn(0.01, 2)),
        kAnyCache);
    limited(app.add_option("--target-error", p.target_error,
                           "radiance, irradiance: render again at finer accuracies until the "
                           "estimated relative error of the indirect light at pixels' middles, at "
                           "the upper end of its interval, is at most this, 0.002..0.5")
                ->check(numberIn(0.002, 0.5))
                ->excludes(accuracy)
                ->default_str(""),
            kCached);
    limited(app.add_option("--time-limit", p.time_limit,
                           "radiance, irradiance: render again at finer accuracies as long as "
                           "that fits into so many seconds of wall time, loading and writing "
                           "included, 0.1..86400; the image then depends on the machine")
                ->check(numberIn(0.1, 86400))
                ->excludes(accuracy)
                ->excludes("--target-error")
                ->default_str(""),
            kCached);
}

// What is kept for other views and runs.
void addCacheOption(CLI::App& app, RenderOptions& o) {
    const Limiter limited{o};
    limited(app.add_option("--cache", o.cache,
                           "radiance, irradiance: file of records. Those of it that the view sees "
                           "are used and only what is missing is gathered; all are written back. "
                           "One of another scene or other options is refused")
                ->type_name("FILE")
                ->check(fileName()),
            kCached)
        ->default_str("");
}

// Where light is kept.
void addKeepingOptions(CLI::App& app, RenderOptions& o) {
    RenderParams& p = o.params;
    const Limiter limited{o};
    limited(app.add_option("--placement", o.placement,
                           "radiance, irradiance: where records go: where a scan of the image "
                           "finds them missing (scan), or first one into each cluster of alike "
                           "surface points (kmeans)")
                ->check(CLI::IsMember(keysOf(kPlacements))),
            kCached);
    limited(app.add_option("--kept-by", o.kept_by,
                           "radiance, irradiance: what keeps light of more bounces than one: "
                           "points spread over surfaces (elements), or a cut through a tree of "
                           "photons (photons)")
                ->check(CLI::IsMember(keysOf(kKeepers))),
            kCached);
    limited(app.add_option("--sh-order", o.sh_order,
                           "radiance: order of the spherical harmonics, 2..10, or auto: by "
                           "material; hints: 2 or 3, auto is 3"),
            {Method::kRadiance, Method::kHints});
    limited(app.add_option("--hints", p.hints,
                           "hints: about so many in each volume, 64..65536; more are better and "
                           "slower")
                ->check(numberIn(64, 65536)),
            {Method::kHints});
}

// What records, and paths, sample.
void addSamplingOptions(CLI::App& app, RenderOptions& o) {
    RenderParams& p = o.params;
    const Limiter limited{o};
    limited(app.add_option("--gather", o.gather,
                           "radiance, irradiance: how a record sees its hemisphere: by rays "
                           "through a hemicube (ray), or rasterised: on a hemicube, or one plane "
                           "with its border stretched to the horizon (border), bare (plane) or "
                           "rescaled (larsen)")
                ->check(CLI::IsMember(keysOf(kGathers))),
            kCached);
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
        kAnyCache)
        ->default_str("");
    o.extent_option =
        limited(app.add_option("--gather-extent", p.gather.extent,
                               "radiance, irradiance: half-width of that plane at "
                               "distance 1 (border 2.5, others 3); not for a hemicube")
                    ->check(numberIn(1, 10)),
                kCached)
            ->default_str("");
    o.bounces_option =
        app.add_option("--bounces", o.bounces,
                       "Bounces of indirect light: all, or so many at the most, 1..64; the octree "
                       "and records that are rasterised have 1")
            ->capture_default_str();
    o.caustics_option =
        app.add_option("--caustics", o.caustics,
                       fmt::format("Photons that find what mirrors, smooth metals and polished "
                                   "surfaces make of lights, in a layer of its own; none: it is "
                                   "part of the indirect layer. Default: {} for radiance and "
                                   "irradiance by rays; reference, which has no photons, keeps it "
                                   "apart as well; none for all else",
                                   p.caustics))
            ->type_name("N|none")
            ->default_str("");
    limited(app.add_option("--spp", p.spp, "reference, denoised: paths a pixel")
                ->check(numberIn(1, 65536)),
            kTraced);
    limited(app.add_option("--seed", p.seed, "reference, denoised: seed of their random numbers")
                ->check(numberIn(0, std::numeric_limits<uint32_t>::max())),
            kTraced);
}

void addProgramOptions(CLI::App& app, RenderOptions& o) {
    addThreadsOption(app, o.threads);
    addGlOption(app, o.gl);
    app.add_option("--json", o.json, "File for all figures as JSON; -: standard output")
        ->type_name("FILE")
        ->check(fileName());
}

void checkMethodOptions(const RenderOptions& o) {
    for (const LimitedOption& limited : o.limited) {
        const auto& methods = limited.methods;
        if (limited.option->count() > 0 &&
            std::find(methods.begin(), methods.end(), o.params.method) == methods.end()) {
            throwUsage(
                "{}: not an option of --method {}{}", limited.option->get_name(), o.method,
                o.by_file ? ", by which a file with lightmaps is shown; choose another" : "");
        }
    }
    if (o.params.method == Method::kLightmap && o.bounces_option->count() > 0) {
        throwUsage("--bounces: lightmaps have those that they were baked with");
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

// Apart where the method keeps them so, unless told otherwise.
int causticsOf(const RenderOptions& o) {
    const bool apart = findsCaustics(o.params.method, o.params.gather_road);
    if (o.caustics_option->count() == 0) {
        return apart ? o.params.caustics : 0;
    }
    const int photons = parseCaustics(o.caustics);
    if (!apart && photons > 0) {
        const bool cached = usesCache(o.params.method);
        throwUsage("--caustics {}: {} does not keep them apart; use none", o.caustics,
                   cached ? "--gather " + o.gather : "--method " + o.method);
    }
    return photons;
}

void checkFileOptions(const RenderOptions& o, FileKind kind) {
    for (const CLI::Option* option : {o.exposure_option, o.tone_option, o.view_option}) {
        if (kind == FileKind::kExr && option->count() > 0) {
            throwUsage("{}: for PNG only; {} stores radiance as it is", option->get_name(),
                       o.output);
        }
    }
    if (kind == FileKind::kPng && o.layers_option->count() > 0) {
        throwUsage("--layers: for EXR only; {} holds one image", o.output);
    }
}

ToDisplay displayOf(const RenderOptions& o) {
    if (o.view.empty()) {
        return toSrgb(kTones.at(o.tone));
    }
    if (o.ocio.empty()) {
        throwUsage("--view {}: of which configuration? Give --ocio FILE, or set OCIO", o.view);
    }
    return colorView(o.ocio, o.view);
}

// Numbers in one form, so that 1 and 1.0 are the same; other text as it is.
std::string canonical(const std::string& text) {
    std::string out;
    std::istringstream parts(text);
    for (std::string part; std::getline(parts, part, ',');) {
        double number = 0.0;
        const char* end = part.data() + part.size();
        const auto [stop, error] = std::from_chars(part.data(), end, number);
        out += out.empty() ? "" : ",";
        out += error == std::errc() && stop == end ? fmt::format("{}", number) : part;
    }
    return out;
}

// Whether the method has it, and it is about the image.
bool isOfImage(const RenderOptions& o, const CLI::Option* option) {
    constexpr std::string_view kOthers[] = {"output", "json",  "threads", "exposure", "tone",
                                            "help",   "cache", "view",    "ocio",     "frames"};
    const std::vector<std::string>& names = option->get_lnames();
    if (names.empty() ||
        std::find(std::begin(kOthers), std::end(kOthers), names[0]) != std::end(kOthers)) {
        return false;
    }
    return std::all_of(o.limited.begin(), o.limited.end(), [&](const LimitedOption& limited) {
        const auto& methods = limited.methods;
        return limited.option != option ||
               std::find(methods.begin(), methods.end(), o.params.method) != methods.end();
    });
}

// In the order of --help, whatever the one they came in, those too that have their default.
std::string settingsOf(const RenderOptions& o) {
    std::string text;
    for (const CLI::Option* option : o.app->get_options()) {
        const bool given = option->count() > 0;
        const std::string value = option == o.method_option ? o.method
                                  : given                   ? option->results().front()
                                                            : option->get_default_str();
        if (isOfImage(o, option) && !value.empty()) {
            text += fmt::format("{}--{}={}", text.empty() ? "" : " ", option->get_lnames()[0],
                                canonical(value));
        }
    }
    return text;
}

std::string defaultOutput(const std::string& scene) {
    return std::filesystem::path(scene).stem().string() + ".exr";
}

}  // namespace

bool tracesPaths(Method method) {
    return method == Method::kReference || method == Method::kDenoised;
}

void addRenderOptions(CLI::App& app, RenderOptions& o) {
    o.app = &app;
    addImageOptions(app, o);
    addMethodOptions(app, o);
    addKeepingOptions(app, o);
    addSamplingOptions(app, o);
    addCacheOption(app, o);
    addProgramOptions(app, o);
}

void understandFrame(RenderOptions& o) {
    const ivec2 size = parseSize(o.size);
    o.params.width = size.x;
    o.params.height = size.y;
    if (!o.crop.empty()) {
        o.part = parseCrop(o.crop);
    }
    o.params.method = kMethods.at(o.method);
    o.params.gather_road = kGathers.at(o.gather).road;
    o.params.gather.kind = kGathers.at(o.gather).hemisphere;
    o.params.placement.sites = kPlacements.at(o.placement);
    o.params.kept_by = kKeepers.at(o.kept_by);
    o.params.sh_order = parseShOrder(o.sh_order);
    o.params.bounces = bouncesOf(o);
    if (o.params.bounces == 1 && o.params.kept_by == KeptBy::kPhotons) {
        throwUsage(
            "--kept-by photons: no light of more bounces is kept with {}",
            o.params.gather_road == GatherRoad::kRaster ? "--gather " + o.gather : "--bounces 1");
    }
    o.params.gl = parseGl(o.gl);
    o.to_display = displayOf(o);
    o.params.all_layers = o.layers == "all";
    if (o.aa_option->count() == 0 && smoothsEdges(o.params.method, o.params.gather_road)) {
        o.params.aa = kSmoothEdges;
    }
    parseExposure(o.exposure);
    parseViewpoint(o.camera_at, o.look_at, o.fov, o.params.camera, o.load);
    checkMethodOptions(o);
    if (o.params.method == Method::kHints && o.params.sh_order > 3) {
        throwUsage("--sh-order {}: hints have 2 or 3", o.sh_order);
    }
    o.params.caustics = causticsOf(o);
    o.load.lightmaps = o.params.method == Method::kLightmap;
    o.load.environment.no_sky =
        usesCache(o.params.method) && o.params.gather_road == GatherRoad::kRaster;
    o.settings = settingsOf(o);
}

void allowLightmaps(RenderOptions& o) {
    o.load.lightmaps = o.load.lightmaps || o.method_option->count() == 0;
}

void understandFile(RenderOptions& o, const Scene& scene) {
    if (o.method_option->count() == 0 && scene.lightmapped) {
        o.method = "lightmap";
        o.by_file = true;
        understandFrame(o);
    }
}

FileKind understand(RenderOptions& o) {
    understandFrame(o);
    o.output = o.output.empty() ? defaultOutput(o.scene) : o.output;
    const FileKind kind = imageKind(o.output);
    checkFileOptions(o, kind);
    return kind;
}

}  // namespace sheen::cli
