// sheen bake: a scene's light into a lightmap.
#include <algorithm>
#include <array>
#include <cctype>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "bake/encode.h"
#include "bake/seams.h"
#include "chart/point_file.h"
#include "cli/bake_options.h"
#include "cli/bake_probes.h"
#include "cli/commands.h"
#include "cli/options.h"
#include "cli/output.h"
#include "cli/sequence_file.h"
#include "core/parallel.h"
#include "core/timer.h"
#include "image/exr.h"
#include "image/png.h"
#include "scene/lightmap_file.h"

namespace sheen::cli {
namespace {

const std::map<std::string, BakeMethod> kBakeMethods = {{"records", BakeMethod::kRecords},
                                                        {"texels", BakeMethod::kTexels},
                                                        {"reference", BakeMethod::kReference}};

void understand(BakeOptions& o) {
    o.params.method = kBakeMethods.at(o.method);
    o.params.bounces = parseBounces(o.bounces);
    const bool paths = o.params.method == BakeMethod::kReference;
    for (const CLI::Option* option : {o.spp_option, o.seed_option}) {
        if (option->count() > 0 && !paths) {
            throwUsage("{}: only --method reference traces paths", option->get_name());
        }
    }
    if (o.accuracy_option->count() > 0 && paths) {
        throwUsage("--accuracy: --method reference has none; --spp makes it finer");
    }
    if (!o.probes.empty()) {
        if (o.outputs.empty()) {
            o.outputs.push_back(std::filesystem::path(o.scene).stem().string() + "_probes.json");
        }
        checkProbeOptions(o);
        return;
    }
    constexpr int kUsualSize = 512;
    if (o.atlas.size == 0 && o.atlas.texels_per_metre == 0.0f) {
        o.atlas.size = kUsualSize;
    }
    if (o.outputs.empty()) {
        o.outputs.push_back(std::filesystem::path(o.scene).stem().string() + "_baked.glb");
    }
    bool any_glb = false, any_exr = false;
    for (const std::string& output : o.outputs) {
        const BakedKind kind = bakedKind(output);
        any_glb = kind == BakedKind::kGlb || any_glb;
        any_exr = kind == BakedKind::kExr || any_exr;
        if (kind == BakedKind::kJson) {
            throwUsage("-o {}: of light probes, which --probes asks for", output);
        }
    }
    if (o.params.directional && !any_exr) {
        throwUsage(
            "--directional: no output is a .exr file, which alone has room for it; give -o one");
    }
    if (o.unlit && !any_glb) {
        throwUsage("--unlit: no output is a .glb file; give -o one");
    }
}

// An output's files: images of several pages are numbered from 0 on before the ending.
std::vector<std::string> filesOf(const std::string& output, int pages) {
    if (pages == 1 || bakedKind(output) == BakedKind::kGlb) {
        return {output};
    }
    std::vector<std::string> files;
    for (int page = 0; page < pages; ++page) {
        const std::filesystem::path path = output;
        files.push_back(
            std::filesystem::path(path).replace_extension(fmt::format(".{}", page)).string() +
            path.extension().string());
    }
    return files;
}

Json bakeJson(const BakeOptions& o, const Lightmap& map, const Baked& baked, const Seams& seams,
              double load, double total) {
    const BakeStats& s = baked.stats;
    const bool paths = o.params.method == BakeMethod::kReference;
    Json json = {{"scene", o.scene},
                 {"outputs", Json::array()},
                 {"method", o.method},
                 {"size", map.atlas.size},
                 {"pages", map.atlas.pages},
                 {"charts", map.atlas.charts},
                 {"own_coordinates", map.atlas.of_file},
                 {"texels_covered", map.covered},
                 {"texels_buried", map.buried},
                 {"texels_pushed", map.pushed},
                 {"texels_at_seams", seams.texels},
                 {"change_across_seams", seams.across},
                 {"change_within_charts", seams.within}};
    for (const std::string& output : o.outputs) {
        for (const std::string& file : filesOf(output, map.atlas.pages)) {
            json["outputs"].push_back(file);
        }
    }
    if (paths) {
        json["spp"] = s.spp;
    } else {
        json["accuracy"] = o.params.accuracy;
        json["records"] = s.records;
        json["records_continued"] = o.params.log->reused();
        json["records_share"] = s.records / std::max(1.0, double(map.covered - map.buried));
        json["texels_uncovered"] = s.uncovered;
    }
    json["seconds"] = {{"total", total},
                       {"load", load},
                       {"lights", s.seconds_lights},
                       {"direct", s.seconds_direct},
                       {"placement", s.seconds_place},
                       {"gather", s.seconds_gather},
                       {"interpolation", s.seconds_interpolate},
                       {"trace", s.seconds_trace}};
    return json;
}

void printBake(const BakeOptions& o, const Lightmap& map, const Baked& baked, const Seams& seams,
               double total) {
    const int pages = map.atlas.pages;
    fmt::print("atlas       {}{} x {} texels, {} charts, {}\n",
               pages > 1 ? fmt::format("{} pages of ", pages) : "", map.atlas.size, map.atlas.size,
               map.atlas.charts,
               map.atlas.of_file ? "by the file's coordinates" : "made for this scene");
    fmt::print("texels      {} covered, {} of them buried, {} moved out of what buries them\n",
               map.covered, map.buried, map.pushed);
    if (o.params.method == BakeMethod::kReference) {
        fmt::print("paths       {} a texel\n", baked.stats.spp);
    } else {
        fmt::print("records     {}: {:.2f}% of the texels\n", baked.stats.records,
                   100.0 * baked.stats.records / std::max(1, map.covered - map.buried));
        if (o.params.log->reused() > 0) {
            fmt::print("continued   with {} of them, gathered before it was interrupted\n",
                       o.params.log->reused());
        }
    }
    if (seams.texels > 0) {
        fmt::print(
            "seams       {} texels; light changes across by {:.3g}, within charts by {:.3g}\n",
            seams.texels, seams.across, seams.within);
    }
    const BakeStats& s = baked.stats;
    fmt::print(
        "seconds     {:.2f}: lights {:.2f}, direct {:.2f}, placement {:.2f}, gather {:.2f}, "
        "interpolation {:.2f}, paths {:.2f}\n",
        total, s.seconds_lights, s.seconds_direct, s.seconds_place, s.seconds_gather,
        s.seconds_interpolate, s.seconds_trace);
}

// The scene's file with the lightmap, which has no image yet.
LightmapFile fileOf(const BakeOptions& o, const Lightmap& map) {
    LightmapFile file = lightmapFileOf(o.scene, map.atlas);
    file.unlit = o.unlit;
    file.lights_baked = o.unlit || !o.params.indirect_only;
    return file;
}

void writeBakedScene(const BakeOptions& o, const std::string& path, const Scene& scene,
                     const Lightmap& map, const Image<vec3>& irradiance) {
    LightmapFile file = fileOf(o, map);
    EncodedLight encoded =
        o.unlit ? encodeUnlit(scene, map, irradiance) : encodeIrradiance(map, irradiance);
    file.pngs = std::move(encoded.pngs);
    file.intensity = encoded.intensity;
    writeLightmapped(path, scene, file);
}

void checkBakeOutputs(const BakeOptions& o, const Scene& scene, int pages) {
    std::vector<OutputFile> files{{"--json", o.json}};
    for (const std::string& output : o.outputs) {
        for (const std::string& file : filesOf(output, pages)) {
            files.push_back({"-o", file});
        }
    }
    checkOutputs(files, scene.files);
}

void writeOutputs(const BakeOptions& o, const Scene& scene, const Lightmap& map,
                  const Baked& baked) {
    const Image<vec3> shown = beauty(baked.frame);
    for (const std::string& output : o.outputs) {
        const std::vector<std::string> files = filesOf(output, map.atlas.pages);
        for (size_t i = 0; i < files.size(); ++i) {
            const auto page = static_cast<int>(i);
            switch (bakedKind(output)) {
                case BakedKind::kExr: {
                    const Baked own = pageOf(map.atlas, baked, page);
                    writeExr(files[i], own.frame, ExrLayers::kBasic, {}, {}, layersOfSh(own.sh));
                    break;
                }
                case BakedKind::kPng:
                    writePng(files[i], pageOf(map.atlas, shown, page), std::nullopt);
                    break;
                case BakedKind::kGlb:
                    writeBakedScene(o, output, scene, map, shown);
                    break;
                case BakedKind::kJson:
                    break;  // of light probes alone
            }
        }
    }
}

ExitCode runBake(BakeOptions& o, Ranks& ranks) {
    const Timer total;
    understand(o);
    setThreadCount(o.threads > 0 ? o.threads : ranks.threads());
    const Timer load;
    o.load.sources = o.probes.empty();
    const Scene scene = loadScene(o.scene, o.load);
    for (const std::string& warning : scene.warnings) {
        warn(warning);
    }
    const double load_seconds = load.seconds();
    if (ranks.first()) {
        checkBakeOutputs(o, scene, 1);
    }
    const Tracer tracer(scene);
    const SequenceKey key = keyOf(*o.app, scene);
    const RankedJob job{.ranks = &ranks, .text = jobText(key, o.outputs.front())};
    if (!ranks.first()) {
        serveBake(tracer, o.params, job);
        return ExitCode::kDone;
    }
    std::optional<GatherLog> log;
    const auto keep_gathered = [&] {
        if (o.params.method != BakeMethod::kReference) {
            log.emplace(o.outputs.front() + ".unfinished", jobText(key, fileHash(ownProgram())));
            o.params.log = &*log;
        }
    };
    if (!o.probes.empty()) {
        keep_gathered();
        runProbes(o, tracer, job, load_seconds);
        log->remove();
        return ExitCode::kDone;
    }
    const Lightmap map = lightmapOf(tracer, atlasOf(scene, o.atlas));
    checkBakeOutputs(o, scene, map.atlas.pages);
    if (std::any_of(o.outputs.begin(), o.outputs.end(), [](const std::string& output) {
            return bakedKind(output) == BakedKind::kGlb;
        })) {
        checkLightmapped(scene, fileOf(o, map));
    }
    keep_gathered();
    const Baked baked = bake(tracer, map, o.params, job);
    writeOutputs(o, scene, map, baked);
    if (log) {
        log->remove();
    }
    if (baked.stats.uncovered > 0) {
        warn(fmt::format("{} texels have no record: their numbers are not sound",
                         baked.stats.uncovered));
    }
    const double seconds = total.seconds();
    const Seams seams = seamsOf(map, beauty(baked.frame));
    writeJson(o.json, bakeJson(o, map, baked, seams, load_seconds, seconds));
    if (wantsText(o.json)) {
        printBake(o, map, baked, seams, seconds);
    }
    return ExitCode::kDone;
}

void addAtlasOptions(CLI::App& app, BakeOptions& o) {
    addSceneOption(app, o.scene);
    app.add_option("-o,--output", o.outputs,
                   "What to write, may be given more than once: .glb, the scene with its "
                   "lightmap; .exr, the lightmap alone with all figures; .png, to look at; "
                   "default: the scene's name with _baked.glb, in the current folder")
        ->type_name("FILE")
        ->allow_extra_args(false)
        ->check(fileName());
    o.of_lightmaps = {
        app.add_option("--size", o.atlas.size,
                       "Texels along each side of the lightmap, of each where --texels-per-metre "
                       "takes several")
            ->check(CLI::Range(kLeastAtlas, kLargestAtlas))
            ->default_str("512, or what --texels-per-metre asks for"),
        app.add_option("--texels-per-metre", o.atlas.texels_per_metre,
                       "Texels along each unit of the scene's surfaces; default: as many as --size "
                       "holds")
            ->check(numberIn(1e-6, 1e6))
            ->default_str("")};
    app.add_option(
           "--probes", o.probes,
           "Instead of a lightmap light probes, for things that move: so many along the axes "
           "of the scene's bounds, or the space between them. -o: .json, as three.js's "
           "LightProbe has them, and .exr; default: the scene's name with _probes.json")
        ->type_name("NxNxN|D")
        ->check(fileName());
}

void addBakeMethodOptions(CLI::App& app, BakeOptions& o) {
    o.of_lightmaps.push_back(
        app.add_option("--method", o.method,
                       "records (gathered at few texels), texels (the same at each of them), "
                       "reference (path tracer)")
            ->check(CLI::IsMember({"records", "texels", "reference"}))
            ->capture_default_str());
    o.accuracy_option =
        app.add_option("--accuracy", o.params.accuracy,
                       "records, texels: largest error of a record's reuse, smaller is better "
                       "and slower")
            ->check(numberIn(0.01, 2))
            ->capture_default_str();
    o.spp_option = app.add_option("--spp", o.params.spp, "reference: paths a texel")
                       ->check(CLI::Range(1, 1 << 24))
                       ->capture_default_str();
    o.seed_option = app.add_option("--seed", o.params.seed, "reference: of its random numbers")
                        ->capture_default_str();
    app.add_option("--bounces", o.bounces, "As sheen render has it: all, or 1..64")
        ->capture_default_str();
    app.add_flag("--indirect-only", o.params.indirect_only,
                 "Leave out the light that comes straight from lights and lamps");
    o.of_lightmaps.push_back(
        app.add_flag("--directional", o.params.directional,
                     ".exr: also where light comes from, for normal maps: spherical harmonics of "
                     "order 2 in layers sh0 to sh3"));
    o.of_lightmaps.push_back(
        app.add_flag("--unlit", o.unlit,
                     ".glb: light and colours in one image, for viewers that know no lightmaps"));
    addEnvironmentOptions(app, o.load.environment);
    app.remove_option(app.get_option("--transparent"));  // no image shows a sky
    addThreadsOption(app, o.threads);
    app.add_option("--json", o.json, "File for all figures as JSON; -: standard output")
        ->type_name("FILE")
        ->check(fileName());
    app.add_flag("-q,--quiet", o.params.quiet, "No progress");
}

}  // namespace

std::vector<ExrColors> layersOfSh(std::span<const Image<vec3>> coefficients) {
    std::vector<ExrColors> layers;
    for (const Image<vec3>& coefficient : coefficients) {
        layers.push_back({fmt::format("sh{}", layers.size()), &coefficient});
    }
    return layers;
}

BakedKind bakedKind(const std::string& path) {
    static const std::map<std::string, BakedKind> kinds = {{".exr", BakedKind::kExr},
                                                           {".png", BakedKind::kPng},
                                                           {".glb", BakedKind::kGlb},
                                                           {".json", BakedKind::kJson}};
    std::string extension = std::filesystem::path(path).extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return std::tolower(c); });
    const auto found = kinds.find(extension);
    if (found == kinds.end()) {
        throwUsage(
            "-o {}: the name of what is baked must end in .glb, .exr or .png, or, of light "
            "probes, .json",
            path);
    }
    return found->second;
}

Command addBake(CLI::App& program, Ranks& ranks) {
    CLI::App* app = program.add_subcommand("bake", "Bake a scene's light into a lightmap");
    const auto o = std::make_shared<BakeOptions>();
    o->app = app;
    addAtlasOptions(*app, *o);
    addBakeMethodOptions(*app, *o);
    return {app, [o, &ranks] { return runBake(*o, ranks); }};
}

}  // namespace sheen::cli
