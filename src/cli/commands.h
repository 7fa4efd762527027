// The subcommands of the program, one file each. A command reads its options, calls the library and
// prints; errors are exceptions, which main.cpp turns into one line and an exit code.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>

#include "core/error.h"
#include "core/ranks.h"

namespace sheen::cli {

struct Command {
    CLI::App* options = nullptr;    ///< parsed() tells whether it was chosen
    std::function<ExitCode()> run;  ///< owns the option values
};

Command addCompare(CLI::App& program);
Command addInfo(CLI::App& program);
Command addManual(CLI::App& program);
Command addCompletion(CLI::App& program);
/// `ranks`: that its work is shared out over; must outlive it.
Command addRender(CLI::App& program, Ranks& ranks);
Command addAnimate(CLI::App& program, Ranks& ranks);
Command addBake(CLI::App& program, Ranks& ranks);
Command addChart(CLI::App& program, Ranks& ranks);
/// `arguments`: of the program, null at the end.
Command addView(CLI::App& program, char** arguments);

}  // namespace sheen::cli
