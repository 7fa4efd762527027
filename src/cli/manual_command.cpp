// sheen manual and sheen completion: what packages install, from the same source as --help.
#include <memory>

#include "cli/commands.h"
#include "cli/manual.h"
#include "cli/options.h"
#include "image/atomic_file.h"

namespace sheen::cli {

namespace {

void writePage(const std::string& folder, const std::string& name, const std::string& page) {
    AtomicFile file(folder + "/" + name + ".1");
    file.write(page);
    file.commit();
}

void writePages(const CLI::App& program, const std::string& folder) {
    writePage(folder, "sheen", manualPage(program, ""));
    for (const CLI::App* app : commandsOf(program)) {
        writePage(folder, "sheen-" + app->get_name(), manualPage(program, app->get_name()));
    }
}

}  // namespace

Command addManual(CLI::App& program) {
    CLI::App* app = program.add_subcommand("manual", "Print a manual page, for man -l -");
    const auto command = std::make_shared<std::string>();
    const auto folder = std::make_shared<std::string>();
    app->add_option("COMMAND", *command, "Of this command; default: of the program");
    app->add_option("-o,--output", *folder, "Write all pages into this folder, and print none")
        ->type_name("FOLDER")
        ->check(fileName())
        ->excludes("COMMAND");
    return {app, [command, folder, &program] {
                if (folder->empty()) {
                    fmt::print("{}", manualPage(program, *command));
                } else {
                    writePages(program, *folder);
                }
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
