// sheen manual and sheen completion: what packages install, from the same source as --help.
#include <memory>

#include "cli/commands.h"
#include "cli/manual.h"

namespace sheen::cli {

Command addManual(CLI::App& program) {
    CLI::App* app = program.add_subcommand("manual", "Print a manual page, for man -l -");
    const auto command = std::make_shared<std::string>();
    app->add_option("COMMAND", *command, "Of this command; default: of the program");
    return {app, [command, &program] {
                fmt::print("{}", manualPage(program, *command));
                return ExitCode::kDone;
            }};
}

Command addCompletion(CLI::App& program) {
    CLI::App* app = program.add_subcommand("completion", "Print a script that completes for bash");
    return {app, [&program] {
                fmt::print("{}", bashCompletion(program));
                return ExitCode::kDone;
            }};
}

}  // namespace sheen::cli
