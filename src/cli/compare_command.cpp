// sheen compare: how far an image is from the reference, and where.
#include <algorithm>
#include <filesystem>
#include <iterator>
#include <memory>

#include "cli/commands.h"
#include "cli/compare_page.h"
#include "cli/compare_pair.h"
#include "cli/frame_names.h"
#include "cli/options.h"
#include "cli/output.h"
#include "image/png.h"
#include "metrics/flicker.h"

namespace sheen::cli {
namespace {

struct CompareOptions {
    std::string test;
    std::string reference;
    std::string layer = "indirect";
    std::string json;
    std::string heatmap;
    std::string page;
    bool sequence = false;
};

void printComparison(const Comparison& c) {
    fmt::print("rel_rmse    {:.3f}% (bias {:+.3f}%)\n", 100.0 * c.rel_rmse, 100.0 * c.bias);
    fmt::print("rel_mse     {:.6g}\n", c.rel_mse);
    fmt::print("pixels      median {:.3f}%, p99 {:.3f}%, max {:.3f}%\n", 100.0 * c.median,
               100.0 * c.p99, 100.0 * c.max);
    if (c.noise_p99 > 0.0) {
        fmt::print("            of the reference's noise alone: median {:.3f}%, p99 {:.3f}%\n",
                   100.0 * c.noise_median, 100.0 * c.noise_p99);
    }
    fmt::print("tile_max    {:.3f}% at pixel {}, {}\n", 100.0 * c.tile_max, c.worst_tile.x,
               c.worst_tile.y);
    fmt::print("noise_share {:.3f}\n", c.noise_share);
    fmt::print("excluded    {} pixels; compared {}\n", c.excluded, c.compared);
}

void checkOptions(const CompareOptions& o) {
    if (!o.heatmap.empty() && imageKind(o.heatmap) != FileKind::kPng) {
        throwUsage("--heatmap {}: must be a .png file", o.heatmap);
    }
    if (!o.page.empty() && std::filesystem::path(o.page).extension() != ".html") {
        throwUsage("--page {}: must be a .html file", o.page);
    }
}

// Numbers of frames that both have.
std::vector<int> framesOfBoth(const CompareOptions& o, const FrameNames& tests,
                              const FrameNames& references) {
    const std::vector<int> of_test = framesThere(tests);
    const std::vector<int> of_reference = framesThere(references);
    std::vector<int> both;
    std::set_intersection(of_test.begin(), of_test.end(), of_reference.begin(), of_reference.end(),
                          std::back_inserter(both));
    if (both.empty()) {
        throwInput("{}: no frame is there that {} has as well; {} and {} are there", o.test,
                   o.reference, of_test.size(), of_reference.size());
    }
    return both;
}

void printSequence(const std::vector<int>& frames, const std::vector<Comparison>& comparisons,
                   const std::optional<Flicker>& flicker) {
    for (size_t i = 0; i < frames.size(); ++i) {
        const Comparison& c = comparisons[i];
        fmt::print("frame {:4}  rel_rmse {:.3f}% (bias {:+.3f}%), tile_max {:.3f}%\n", frames[i],
                   100.0 * c.rel_rmse, 100.0 * c.bias, 100.0 * c.tile_max);
    }
    if (flicker) {
        fmt::print("flicker     {:.3f}% over {} pairs of frames", 100.0 * flicker->value,
                   flicker->pairs);
        if (flicker->resolution > 0.0) {
            fmt::print("; the reference's noise hides less than {:.3f}%",
                       100.0 * flicker->resolution);
        }
        fmt::print("\n");
    } else {
        fmt::print("flicker     none: no two frames that both have are neighbours\n");
    }
}

ExitCode runSequence(const CompareOptions& o) {
    const FrameNames tests = parseFrameNames("IMAGE", o.test);
    const FrameNames references = parseFrameNames("REFERENCE", o.reference);
    const std::vector<int> frames = framesOfBoth(o, tests, references);
    std::vector<std::string> inputs;
    for (const int frame : frames) {
        inputs.insert(inputs.end(), {tests(frame), references(frame)});
    }
    checkOutputs({{"--json", o.json}}, inputs);
    std::vector<Comparison> comparisons;
    FlickerMeter meter;
    Json list = Json::array();
    for (const int frame : frames) {
        const ComparedPair pair(tests(frame), references(frame), o.layer);
        comparisons.push_back(compareImages(pair.input()));
        meter.add(frame, pair.input());
        list.push_back({{"frame", frame}});
        list.back().update(comparisonJson(comparisons.back()));
    }
    const std::optional<Flicker> flicker = meter.result();
    Json json = {{"flicker", nullptr}, {"frames", list}};
    if (flicker) {
        json["flicker"] = {{"value", flicker->value},
                           {"resolution", flicker->resolution},
                           {"noise_share", flicker->noise_share},
                           {"pairs", flicker->pairs}};
    }
    writeJson(o.json, json);
    if (wantsText(o.json)) {
        printSequence(frames, comparisons, flicker);
    }
    for (size_t i = 0; i < frames.size(); ++i) {
        checkJudged(comparisons[i], tests(frames[i]), references(frames[i]));
    }
    return ExitCode::kDone;
}

ExitCode runCompare(const CompareOptions& o) {
    checkOptions(o);
    if (o.sequence) {
        return runSequence(o);
    }
    if (!o.page.empty()) {
        return comparePage(o.test, o.reference, o.layer, o.page, o.json);
    }
    checkOutputs({{"--heatmap", o.heatmap}, {"--json", o.json}}, {o.test, o.reference});
    const ComparedPair pair(o.test, o.reference, o.layer);
    const Comparison comparison = compareImages(pair.input());
    if (!o.heatmap.empty()) {
        writePng(o.heatmap, bytesFromDisplay(heatmap(pair.input())));
    }
    writeJson(o.json, comparisonJson(comparison));
    if (wantsText(o.json)) {
        printComparison(comparison);
    }
    checkJudged(comparison, o.test, o.reference);
    return ExitCode::kDone;
}

}  // namespace

Command addCompare(CLI::App& program) {
    CLI::App* app = program.add_subcommand("compare", "Measure an image's error");
    const auto options = std::make_shared<CompareOptions>();
    app->add_option("IMAGE", options->test, "EXR file to judge, or a folder of them (--page)")
        ->type_name("FILE")
        ->required()
        ->check(fileName());
    app->add_option(
           "REFERENCE", options->reference,
           "EXR file, or folder, to judge by; the variance it carries is taken into account, and "
           "where more than half of the difference is its noise, nothing is judged "
           "(exit code 3)")
        ->type_name("FILE")
        ->required()
        ->check(fileName());
    app->add_option("--layer", options->layer, "Layer to compare")
        ->check(
            CLI::IsMember({"indirect", "direct", "caustic", kGlobal, "indirect_diffuse", "beauty"}))
        ->capture_default_str();
    app->add_option("--json", options->json, "File for all figures as JSON; -: standard output")
        ->type_name("FILE")
        ->check(fileName());
    CLI::Option* heatmap =
        app->add_option(
               "--heatmap", options->heatmap,
               "PNG file for the relative error of each pixel, 0.1% (violet) to 100% (yellow)")
            ->type_name("FILE")
            ->check(fileName());
    app->add_flag("--sequence", options->sequence,
                  "IMAGE and REFERENCE count frames, as in a/frame_%04d.exr: the error of each "
                  "frame that both have, and how much it changes from frame to frame (flicker)")
        ->excludes(heatmap);
    app->add_option("--page", options->page,
                    "IMAGE and REFERENCE are folders: a page of the images that both have, with "
                    "their references, false colours and errors, the worst first")
        ->type_name("FILE.html")
        ->check(fileName())
        ->excludes(heatmap)
        ->excludes("--sequence");
    return {app, [options] { return runCompare(*options); }};
}

}  // namespace sheen::cli
