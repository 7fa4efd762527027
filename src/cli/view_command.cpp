// sheen view: checks its options and hands over to the program that shows windows, which lies
// beside this one: so nothing else needs a window system's libraries.
#include <memory>

#include "cli/commands.h"
#include "cli/sibling.h"
#include "cli/view_options.h"

namespace sheen::cli {
namespace {

ExitCode runView(ViewOptions& o, char** arguments) {
    understand(o);
    throwEnvironment(
        "view: {} cannot be run; install the package sheen-viewer, or build with SHEEN_VIEWER",
        becomeSibling("sheen-viewer", arguments));
}

}  // namespace

Command addView(CLI::App& program, char** arguments) {
    CLI::App* app = program.add_subcommand(
        "view", "Open a window in which a scene is lit at once and becomes better");
    const auto options = std::make_shared<ViewOptions>();
    addViewOptions(*app, *options);
    return {app, [options, arguments] { return runView(*options, arguments); }};
}

}  // namespace sheen::cli
