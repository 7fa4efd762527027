#include "cli/render_report.h"

#include <cmath>
#include <filesystem>
#include <map>
#include <utility>

#include "cli/mattes.h"
#include "core/error.h"
#include "core/parallel.h"
#include "render/black_frame.h"

namespace sheen::cli {
namespace {

// Materials may share a name; keys of an object may not.
Json shOrders(const std::vector<MaterialOrder>& orders) {
    Json json = Json::object();
    for (size_t i = 0; i < orders.size(); ++i) {
        const std::string& name = orders[i].material;
        json[json.contains(name) ? fmt::format("{} #{}", name, i) : name] = orders[i].order;
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

ivec2 writtenSize(const RenderOptions& o) {
    return o.part ? o.part->size : ivec2(o.params.width, o.params.height);
}

// What the cache did.
void printCached(const RenderOptions& o, const RenderStats& stats) {
    fmt::print("gather    {}\n", o.gather);
    if (stats.elements > 0) {
        fmt::print("bounces   {}: kept at {} {}, none near for {:.2g}% of what asks them\n",
                   o.bounces, stats.elements,
                   o.params.kept_by == KeptBy::kPhotons ? "nodes of a cut" : "elements",
                   100.0 * stats.elements_missed_share);
    }
    if (stats.caustic_photons > 0) {
        fmt::print("caustics  {} photons of {} met what is seen\n", stats.caustic_photons,
                   o.params.caustics);
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
        100.0 * stats.diffuse_share, 100.0 * stats.corrected_share, 100.0 * stats.too_glossy_share);
    if (o.params.aa > 1) {
        fmt::print("edges     {} pixels of {} samples; {} records for what no pixel sees\n",
                   stats.pixels_edges, o.params.aa, stats.edge_records);
    }
    fmt::print("materials {}\n", orderSummary(stats.sh_order));
    fmt::print("renderer  {}, {} threads\n", stats.gl_renderer, threadCount());
}

}  // namespace

void warnOf(const RenderOptions& o, const Scene& scene, const RenderResult& result, double limit) {
    if (result.stats.nonfinite_pixels > 0) {
        warn(fmt::format("{}: {} pixels are not finite", o.output, result.stats.nonfinite_pixels));
    }
    RenderParams seen = o.params;
    if (o.part) {
        seen.window = {.first = o.part->first, .whole = {seen.width, seen.height}};
    }
    const std::string black = whyBlack(scene, viewOf(scene, seen), result.frame);
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
}

Json statsJson(const RenderOptions& o, const RenderStats& stats) {
    Json seconds = {{"total", stats.seconds.total}};
    for (const Stage& stage : kStages) {
        seconds[stage.name] = stats.seconds.*stage.seconds;
    }
    const ivec2 written = writtenSize(o);
    Json json = {{"method", o.method},
                 {"size", {written.x, written.y}},
                 {"threads", threadCount()},
                 {"output", o.output},
                 {"records", stats.records},
                 {"records_of_clusters", stats.records_of_clusters},
                 {"records_reused", stats.records_reused},
                 {"records_renewed", stats.records_renewed},
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
        json["caustic_photons"] = stats.caustic_photons;
        json["elements_missed_share"] = stats.elements_missed_share;
    }
    if (o.params.method == Method::kHints) {
        json["hints"] = stats.hints;
        json["lit_samples"] = stats.lit_samples;
    }
    if (tracesPaths(o.params.method)) {
        json["mrays_per_second"] = stats.mrays_per_second;
        json["spp"] = stats.spp;
    }
    return json;
}

ExrNotes notesOf(const RenderOptions& o, const RenderStats& stats) {
    ExrNotes notes{.texts = {{"software", "sheen " SHEEN_VERSION},
                             {"sheen.scene", std::filesystem::path(o.scene).filename().string()},
                             {"sheen.method", o.method},
                             {"sheen.options", o.settings}},
                   .numbers = {{"whiteLuminance", 1.0f}}};  // of (1, 1, 1), nits
    const auto add = [&](const char* name, double value) {
        if (std::isfinite(value)) {
            notes.numbers[name] = static_cast<float>(value);
        }
    };
    add("sheen.estimated_rel_rmse", stats.estimated_rel_rmse);
    add("sheen.estimate_low", stats.estimate_low);
    add("sheen.estimate_high", stats.estimate_high);
    if (usesCache(o.params.method)) {
        add("sheen.accuracy", stats.accuracy);
        add("sheen.records", stats.records);
    }
    if (tracesPaths(o.params.method)) {
        add("sheen.spp", stats.spp);
    }
    return notes;
}

void writeFrameExr(const RenderOptions& o, const Scene& scene, const RenderResult& result) {
    const bool all = o.params.all_layers;
    writeExr(o.output, result.frame, all ? ExrLayers::kAll : ExrLayers::kBasic,
             notesOf(o, result.stats), all ? mattesOf(scene, result.frame) : std::vector<Matte>());
}

void printStats(const RenderOptions& o, const RenderStats& stats) {
    std::string stages;
    for (const Stage& stage : kStages) {
        const double value = stats.seconds.*stage.seconds;
        if (value > 0.0) {
            stages += fmt::format("{}{} {:.3f}", stages.empty() ? "" : ", ", stage.name, value);
        }
    }
    fmt::print("seconds   {:.3f}: {}\n", stats.seconds.total, stages);
    if (tracesPaths(o.params.method)) {
        fmt::print("rays      {:.2f} million a second, {} threads; {} paths a pixel\n",
                   stats.mrays_per_second, threadCount(), stats.spp);
    } else if (o.params.method == Method::kHints) {
        fmt::print("hints     {}, of {} samples of lit surfaces; pixels that see none: {} of {}\n",
                   stats.hints, stats.lit_samples, stats.pixels_uncovered, stats.pixels_geometry);
    } else if (o.params.method == Method::kLightmap) {
        fmt::print("lightmap  of the file, in place of records; lobes by rays: {:.1f}% of pixels\n",
                   100.0 * stats.too_glossy_share);
    } else {
        const std::string of_clusters =
            o.params.placement.sites == SitesBy::kKMeans
                ? fmt::format(" ({} of clusters)", stats.records_of_clusters)
                : "";
        fmt::print("records   {}{}; pixels without one: {} of {}\n", stats.records, of_clusters,
                   stats.pixels_uncovered, stats.pixels_geometry);
    }
    if (usesCache(o.params.method)) {
        printCached(o, stats);
    }
    if (stats.negative_pixels > 0) {
        fmt::print("clamped   {} negative pixels\n", stats.negative_pixels);
    }
    const ivec2 written = writtenSize(o);
    fmt::print("wrote     {} ({}x{}, {})\n", o.output, written.x, written.y, o.method);
}

}  // namespace sheen::cli
