#include "cli/program.h"

#include <csignal>
#include <string>

#include "cli/output.h"
#include "image/atomic_file.h"

namespace sheen::cli {
namespace {

const char* const kFooter =
    "Exit codes: 0 done, 1 a bug, 2 usage, 3 bad input, 4 environment.\n"
    "Help for a subcommand: sheen SUBCOMMAND --help";

void endBySignal(int signal) {
    removePendingTemporaries();
    std::signal(signal, SIG_DFL);
    std::raise(signal);
}

void installSignalHandlers() {
    for (const int signal : {SIGINT, SIGTERM, SIGHUP}) {
        if (std::signal(signal, endBySignal) == SIG_IGN) {
            std::signal(signal, SIG_IGN);  // as under nohup
        }
    }
    // A file that grows over the limit is then an error of write(), reported like a full disk.
    std::signal(SIGXFSZ, SIG_IGN);
}

int parseAndRun(int argc, char** argv, const std::function<std::vector<Command>(CLI::App&)>& add) {
    CLI::App program("Glossy global illumination without noise, by radiance caching.", "sheen");
    program.set_version_flag("--version", "sheen " SHEEN_VERSION, "Print the version and exit");
    program.set_help_flag("-h,--help", "Print this help and exit");
    program.require_subcommand(1);
    program.footer(kFooter);
    const std::vector<Command> commands = add(program);
    try {
        program.parse(argc, argv);
    } catch (const CLI::ParseError& error) {
        if (error.get_exit_code() == static_cast<int>(CLI::ExitCodes::Success)) {
            return program.exit(error);  // --help, --version
        }
        if (argc > 1 && argv[1][0] != '-' && program.get_subcommands().empty()) {
            throwUsage("{}: no such subcommand (see sheen --help)", argv[1]);
        }
        std::string where = "sheen";
        for (const Command& command : commands) {
            where += command.options->parsed() ? " " + command.options->get_name() : "";
        }
        throwUsage("{} (see {} --help)", error.what(), where);
    }
    for (const Command& command : commands) {
        if (command.options->parsed()) {
            return static_cast<int>(command.run());
        }
    }
    throw std::logic_error("no subcommand was parsed");
}

}  // namespace

int printFailure(const Failure& failure) {
    say(fmt::format("sheen: error: {}\n", failure.message));
    return static_cast<int>(failure.code);
}

int runProgram(int argc, char** argv, const std::function<std::vector<Command>(CLI::App&)>& add,
               const std::function<int(const Failure&)>& on_failure) {
    installSignalHandlers();
    try {
        const int code = parseAndRun(argc, argv, add);
        flushOutput();
        return code;
    } catch (...) {
        return on_failure(failureOf(std::current_exception()));
    }
}

}  // namespace sheen::cli
