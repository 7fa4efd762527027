// sheen render: one frame of a scene into an EXR or PNG file.
#include <algorithm>
#include <filesystem>
#include <memory>
#include <utility>

#include "cli/commands.h"
#include "cli/render_report.h"
#include "core/parallel.h"
#include "core/timer.h"
#include "image/exr.h"
#include "image/png.h"
#include "render/crop.h"
#include "render/record_file.h"

namespace sheen::cli {
namespace {

// Of a time limit: what writing may take, and ending.
constexpr double kWriteShare = 0.03;

void writeFrame(const RenderOptions& o, FileKind kind, const Frame& frame) {
    if (kind == FileKind::kPng) {
        writePng(o.output, frame, parseExposure(o.exposure), toneCurve(o));
    } else {
        writeExr(o.output, frame, o.params.all_layers ? ExrLayers::kAll : ExrLayers::kBasic);
    }
}

RenderResult renderWanted(const Scene& scene, const RenderOptions& o) {
    Session session(scene);
    const auto render = [&] {
        return o.part ? renderPart(session, o.params, *o.part) : session.render(o.params);
    };
    if (o.cache.empty()) {
        return render();
    }
    const RecordOrigin origin = {sceneFingerprint(scene), recordRecipe(o.params)};
    KeptRecords kept;
    if (std::filesystem::exists(o.cache)) {
        kept = loadRecords(o.cache, origin);
    }
    session.keepRecords(std::move(kept), origin.recipe);
    RenderResult result = render();
    saveRecords(o.cache, session.records(), origin);
    return result;
}

ExitCode runRender(RenderOptions& o) {
    const Timer total;
    const FileKind kind = understand(o);
    setThreadCount(o.threads);

    const Timer load;
    const Scene scene = loadScene(o.scene, o.load);
    for (const std::string& warning : scene.warnings) {
        warn(warning);
    }
    const double load_seconds = load.seconds();
    checkOutputs({{"-o", o.output}, {"--json", o.json}, {"--cache", o.cache}}, scene.files);

    const double limit = o.params.time_limit;
    if (limit > 0.0) {
        // Above 0, which would be no limit.
        constexpr double kLeast = 1e-3;
        o.params.time_limit = std::max(limit - total.seconds() - kWriteShare * limit, kLeast);
    }
    RenderResult result = renderWanted(scene, o);
    const Timer write;
    writeFrame(o, kind, result.frame);
    result.stats.seconds.write = write.seconds();
    result.stats.seconds.load = load_seconds;
    result.stats.seconds.total = total.seconds();
    warnOf(o, scene, result, limit);
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
    addRenderOptions(*app, *options);
    return {app, [options] { return runRender(*options); }};
}

}  // namespace sheen::cli
