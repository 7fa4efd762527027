// sheen chart: error against time of every method, measured on scenes and shown on a page.
#include <fmt/format.h>

#include <filesystem>
#include <memory>
#include <optional>

#include "chart/chart.h"
#include "chart/point_file.h"
#include "chart/report.h"
#include "cli/commands.h"
#include "cli/options.h"
#include "cli/output.h"
#include "cli/sequence_file.h"
#include "core/progress.h"

namespace sheen::cli {
namespace {

struct ChartOptions {
    std::vector<std::string> methods;
    std::string size = "512x512";
    std::string bounces = "1";
    std::string sequences, bakes;  // files
    ChartParams params;
};

// A unit of work is a point, as numbers of its scene, method and setting. Measures it into the
// chart's folder.
std::string measurePoint(const ChartParams& all, const std::string& unit) {
    const Json json = Json::parse(unit);
    ChartParams params = all;
    params.scenes = {all.scenes.at(json.at(0).get<size_t>())};
    params.methods = {all.methods.at(json.at(1).get<size_t>())};
    params.only_setting = params.methods.front().settings.at(json.at(2).get<size_t>()).value;
    params.shader_cache =
        fmt::format("shader_cache.{}", fmt::join(json.get<std::vector<size_t>>(), "."));
    params.quiet = true;
    measureChart(params);
    return {};
}

// Has all points measured, each by the rank that is free. A scene's first brings its reference,
// which the others need.
void measurePoints(const ChartParams& params, Ranks& ranks, const std::string& job) {
    std::vector<std::string> first, others;
    for (size_t s = 0; s < params.scenes.size(); ++s) {
        for (size_t m = 0; m < params.methods.size(); ++m) {
            for (size_t k = 0; k < params.methods[m].settings.size(); ++k) {
                (m == 0 && k == 0 ? first : others).push_back(Json::array({s, m, k}).dump());
            }
        }
    }
    Progress progress("points", static_cast<int64_t>(first.size() + others.size()));
    for (const std::vector<std::string>& units : {first, others}) {
        ranks.share(
            job, units, [&](const std::string& unit) { return measurePoint(params, unit); },
            [&](size_t, const std::string&) { progress.advance(); });
    }
}

// What ranks must agree upon: times of different machines do not compare.
std::string jobText(const CLI::App& app, const ChartParams& params) {
    const ChartHost host = hostOf(params);
    std::string text = fmt::format("{}\n{}\n{}\n{}\n{}", host.version, host.build, host.cpu,
                                   host.threads, optionsText(app));
    for (const std::string& scene : params.scenes) {
        text += fmt::format("\n{} {}", scene, fileHash(scene));
    }
    return text;
}

void printChart(const Chart& chart, const std::string& folder) {
    for (const ChartScene& scene : chart.scenes) {
        fmt::print("{} ({}); reference's noise {:.2f}%\n", scene.name, scene.camera,
                   100 * scene.noise_rel_rmse);
        for (const ChartPoint& point : scene.points) {
            fmt::print("  {:<10} {:<30} {:8.2f} s  rel_rmse {:6.2f}%{}\n", point.method,
                       point.setting, point.measured.seconds(), 100 * point.errors.rel_rmse,
                       point.errors.judged ? "" : "  (not judged: mostly the reference's noise)");
        }
    }
    fmt::print("wrote     {}\n", (std::filesystem::path(folder) / "chart.html").string());
}

ExitCode runChart(const CLI::App& app, ChartOptions& o, Ranks& ranks) {
    const ivec2 size = parseSize(o.size);
    o.params.width = size.x;
    o.params.height = size.y;
    o.params.bounces = parseBounces(o.bounces);
    o.params.methods = chooseMethods(o.methods, o.params.bounces);
    std::optional<Sequences> sequences;
    std::optional<Bakes> bakes;
    if (!o.sequences.empty()) {
        sequences = readSequences(o.sequences);  // before anything is measured
    }
    if (!o.bakes.empty()) {
        bakes = readBakes(o.bakes);
    }
    o.params.program = ownProgram();
    o.params.version = SHEEN_VERSION;
    if (ranks.count() > 1) {
        const std::string job = jobText(app, o.params);
        if (!ranks.first()) {
            ranks.serve(job, [&](const std::string& unit) { return measurePoint(o.params, unit); },
                        {});
            return ExitCode::kDone;
        }
        measurePoints(o.params, ranks, job);
    }
    Chart chart = measureChart(o.params);  // what is measured is taken from the folder
    chart.sequences = std::move(sequences);
    chart.bakes = std::move(bakes);
    writeReport(o.params.folder, chart);
    printChart(chart, o.params.folder);
    return ExitCode::kDone;
}

}  // namespace

Command addChart(CLI::App& program, Ranks& ranks) {
    CLI::App* app = program.add_subcommand("chart", "Chart error against time of all methods");
    const auto options = std::make_shared<ChartOptions>();
    ChartParams& p = options->params;
    app->add_option("SCENE", p.scenes, "glTF scenes, .glb or .gltf")
        ->type_name("FILE...")
        ->required()
        ->check(fileName());
    app->add_option("-o,--output", p.folder,
                    "Folder for chart.html, chart.csv and chart.json; also keeps references and "
                    "points, so that an interrupted chart continues")
        ->type_name("FOLDER")
        ->required()
        ->check(fileName());
    std::string known;
    for (const SweepMethod& method : sweepMethods()) {
        known += (known.empty() ? "" : ",") + method.name;
    }
    app->add_option("--methods", options->methods,
                    "Methods to sweep; default: those that have the bounces of " + known)
        ->type_name("NAME,...")
        ->delimiter(',');
    app->add_option("--size", options->size, "Width x height in pixels, each 1..16384")
        ->capture_default_str();
    app->add_option("--bounces", options->bounces,
                    "Bounces of indirect light: all, or so many at the most, 1..64; octree and "
                    "rasterised have 1, photons more")
        ->capture_default_str();
    app->add_option("--camera", p.camera, "Name or number of a camera; default: the first");
    addEnvironmentOptions(*app, p.environment);
    app->add_option("--reference-spp", p.reference_spp,
                    "Paths a pixel of the references; points whose error is mostly a reference's "
                    "noise are marked")
        ->check(numberIn(16, 65536))
        ->capture_default_str();
    app->add_option("--repeats", p.repeats,
                    "Warm runs of each point, of which the median counts; fewer where they take "
                    "more than a minute in all")
        ->check(numberIn(1, 99))
        ->capture_default_str();
    app->add_option("--sequences", options->sequences,
                    "Also shows how methods do on scenes that move, as bench/sequences.py --json "
                    "wrote it to this file")
        ->type_name("FILE")
        ->check(fileName());
    app->add_option("--bakes", options->bakes,
                    "Also shows how methods bake lightmaps, as bench/bake.py --json wrote it to "
                    "this file")
        ->type_name("FILE")
        ->check(fileName());
    addGlOption(*app, p.gl);
    app->add_flag("--any-build", p.any_build,
                  "Also take stored points that another build of the program completed");
    return {app, [app, options, &ranks] { return runChart(*app, *options, ranks); }};
}

}  // namespace sheen::cli
