// Runs a program as a user would from a shell, and takes its time.
#pragma once

#include <string>
#include <vector>

namespace sheen {

struct ChildRun {
    double seconds = 0;  ///< wall clock, from before the process starts until it has ended
    std::string out;     ///< what it wrote to standard output
    std::vector<std::string> warnings = {};  ///< of a sheen command, without "sheen: warning: "
};

/// Runs `command` (program and arguments) with `variables` ("NAME=value") added to the environment,
/// until it ends; it is ended too where this program is. An error of a sheen command is rethrown
/// with its exit code; environment error where the program cannot be run or a signal ended it.
ChildRun runChild(const std::vector<std::string>& command,
                  const std::vector<std::string>& variables);

}  // namespace sheen
