// What the programs have in common: arguments to a command, errors to one line and an exit code.
#pragma once

#include <functional>
#include <vector>

#include "cli/commands.h"

namespace sheen::cli {

/// Parses the arguments by the commands that `add` adds, runs the one that was chosen, and returns
/// the exit code.
int runProgram(int argc, char** argv, const std::function<std::vector<Command>(CLI::App&)>& add);

}  // namespace sheen::cli
