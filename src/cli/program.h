// What the programs have in common: arguments to a command, errors to one line and an exit code.
#pragma once

#include <functional>
#include <vector>

#include "cli/commands.h"
#include "core/failure.h"

namespace sheen::cli {

/// Prints the error line; returns its exit code.
int printFailure(const Failure& failure);

/// Parses the arguments by the commands that `add` adds, runs the one that was chosen, and returns
/// the exit code, of an error that of `on_failure`.
int runProgram(int argc, char** argv, const std::function<std::vector<Command>(CLI::App&)>& add,
               const std::function<int(const Failure&)>& on_failure = printFailure);

}  // namespace sheen::cli
