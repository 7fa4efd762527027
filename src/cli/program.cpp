#include "cli/program.h"

#include <algorithm>
#include <csignal>
#include <new>
#include <string>
#include <system_error>

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

int reportError(ExitCode code, std::string message) {
    std::replace(message.begin(), message.end(), '\n', ' ');
    say(fmt::format("sheen: error: {}\n", message));
    return static_cast<int>(code);
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
            return reportError(ExitCode::kUsage,
                               fmt::format("{}: no such subcommand (see sheen --help)", argv[1]));
        }
        std::string where = "sheen";
        for (const Command& command : commands) {
            where += command.options->parsed() ? " " + command.options->get_name() : "";
        }
        return reportError(ExitCode::kUsage,
                           fmt::format("{} (see {} --help)", error.what(), where));
    }
    for (const Command& command : commands) {
        if (command.options->parsed()) {
            return static_cast<int>(command.run());
        }
    }
    throw std::logic_error("no subcommand was parsed");
}

}  // namespace

int runProgram(int argc, char** argv, const std::function<std::vector<Command>(CLI::App&)>& add) {
    installSignalHandlers();
    try {
        const int code = parseAndRun(argc, argv, add);
        flushOutput();
        return code;
    } catch (const Error& error) {
        return reportError(error.code(), error.what());
    } catch (const std::system_error& error) {  // of threads, and of printing
        return reportError(ExitCode::kEnvironment, error.what());
    } catch (const std::bad_alloc&) {
        return reportError(ExitCode::kEnvironment, "out of memory: try a smaller --size");
    } catch (const std::exception& error) {
        return reportError(ExitCode::kBug, fmt::format("{}; this is a bug", error.what()));
    }
}

}  // namespace sheen::cli
