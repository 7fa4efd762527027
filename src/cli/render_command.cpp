// sheen render: one frame of a scene into an EXR or PNG file.
#include <algorithm>
#include <memory>

#include "cli/commands.h"
#include "cli/render_report.h"
#include "cli/render_wanted.h"
#include "cli/sequence_file.h"
#include "core/parallel.h"
#include "core/timer.h"
#include "image/png.h"
#include "render/shared_frame.h"

namespace sheen::cli {
namespace {

// Of a time limit: what writing may take, and ending.
constexpr double kWriteShare = 0.03;

ExitCode runRender(const CLI::App& app, RenderOptions& o, Ranks& ranks) {
    const Timer total;
    const FileKind kind = understand(o);
    allowLightmaps(o);
    setThreadCount(o.threads > 0 ? o.threads : ranks.threads());

    const Timer load;
    const Scene scene = loadScene(o.scene, o.load);
    for (const std::string& warning : scene.warnings) {
        warn(warning);
    }
    understandFile(o, scene);
    const double load_seconds = load.seconds();
    RankedJob job{.ranks = &ranks};
    if (job.isShared()) {
        checkShared(o.params);
        job.text = jobText(keyOf(app, scene), o.output);
    }
    if (!ranks.first()) {
        serveFrame(scene, o.params, job);
        return ExitCode::kDone;
    }
    checkOutputs({{"-o", o.output}, {"--json", o.json}, {"--cache", o.cache}}, scene.files);

    const double limit = o.params.time_limit;
    if (limit > 0.0) {
        // Above 0, which would be no limit.
        constexpr double kLeast = 1e-3;
        o.params.time_limit = std::max(limit - total.seconds() - kWriteShare * limit, kLeast);
    }
    Session session(scene, job);
    RenderResult result = renderWanted(session, scene, o);
    const Timer write;
    if (kind == FileKind::kPng) {
        writePng(o.output, result.frame, parseExposure(o.exposure), o.to_display);
    } else {
        writeFrameExr(o, scene, result);
    }
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

Command addRender(CLI::App& program, Ranks& ranks) {
    CLI::App* app = program.add_subcommand("render", "Render one frame of a scene");
    const auto options = std::make_shared<RenderOptions>();
    addRenderOptions(*app, *options);
    return {app, [app, options, &ranks] { return runRender(*app, *options, ranks); }};
}

}  // namespace sheen::cli
