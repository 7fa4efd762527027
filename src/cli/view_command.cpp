// sheen view: checks its options and hands over to the program that shows windows, which lies
// beside this one: so nothing else needs a window system's libraries.
#include <unistd.h>

#include <filesystem>
#include <memory>

#include "cli/commands.h"
#include "cli/view_options.h"

namespace sheen::cli {
namespace {

ExitCode runView(ViewOptions& o, char** arguments) {
    understand(o);
    const std::filesystem::path program =
        std::filesystem::read_symlink("/proc/self/exe").replace_filename("sheen-viewer");
    execv(program.c_str(), arguments);
    throwEnvironment(
        "view: {} cannot be run; install the package sheen-viewer, or build with "
        "SHEEN_VIEWER",
        program.string());
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
