// What is made of the program's own description of its options beside --help: manual pages and
// completion for shells.
#pragma once

#include <CLI/CLI.hpp>
#include <string>
#include <vector>

namespace sheen::cli {

/// The program's, in the order they were added.
std::vector<const CLI::App*> commandsOf(const CLI::App& program);

/// The manual page, as troff, of the program, or of one of its commands where `command` names it.
/// Usage error where there is none.
std::string manualPage(const CLI::App& program, const std::string& command);

/// A script that bash sources: completes commands, options and the values of those that have few.
std::string bashCompletion(const CLI::App& program);

}  // namespace sheen::cli
