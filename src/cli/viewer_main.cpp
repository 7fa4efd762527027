// The program `sheen-viewer`: what `sheen view` runs, with the same arguments.
#include <memory>

#include "cli/output.h"
#include "cli/program.h"
#include "cli/view_options.h"
#include "core/parallel.h"
#include "viewer/viewer.h"

namespace sheen::cli {
namespace {

ExitCode runWindow(ViewOptions& o) {
    understand(o);
    setThreadCount(o.threads);
    checkOutputs({{"--screenshot", o.screenshot}, {"--json", o.json}}, {o.scene});
    const std::optional<ViewerFigures> figures =
        runViewer({.scene = o.scene,
                   .load = o.load,
                   .render = o.params,
                   .display = {.exposure = parseExposure(o.exposure),
                               .tone = o.tone == "none" ? ToneCurve::kNone : ToneCurve::kNeutral},
                   .benchmark = o.benchmark,
                   .screenshot = o.screenshot,
                   .screenshot_after = o.frames});
    if (figures) {
        Json stages = {{"total", figures->stages.total}};
        for (const Stage& stage : kStages) {
            stages[stage.name] = figures->stages.*stage.seconds;
        }
        const Json json = {{"seconds_to_first", figures->seconds_to_first},
                           {"seconds_to_full", figures->seconds_to_full},
                           {"fps_fill", figures->fps_fill},
                           {"fps_full", figures->fps_full},
                           {"seconds_gbuffer_512", figures->seconds_gbuffer},
                           {"records", figures->records},
                           {"stages_full", stages}};
        writeJson(o.json, json);
        if (wantsText(o.json)) {
            fmt::print(
                "first     {:.2f} s, complete {:.2f} s\n"
                "path      {:.1f} frames/s, again {:.1f} frames/s\n"
                "records   {}\n"
                "yardstick {:.3f} s for a G-buffer of 512 x 512\n",
                figures->seconds_to_first, figures->seconds_to_full, figures->fps_fill,
                figures->fps_full, figures->records, figures->seconds_gbuffer);
        }
    }
    return ExitCode::kDone;
}

}  // namespace
}  // namespace sheen::cli

int main(int argc, char** argv) {
    using namespace sheen::cli;
    return runProgram(argc, argv, [](CLI::App& program) {
        CLI::App* app = program.add_subcommand("view", "Open a window");
        const auto options = std::make_shared<ViewOptions>();
        addViewOptions(*app, *options);
        return std::vector<Command>{{app, [options] { return runWindow(*options); }}};
    });
}
