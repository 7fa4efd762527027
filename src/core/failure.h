// What an exception means to whoever runs the program: one line, and an exit code.
#pragma once

#include <exception>
#include <string>

#include "core/error.h"

namespace sheen {

struct Failure {
    ExitCode code = ExitCode::kBug;
    std::string message;  ///< one line
};

/// Of any exception; of one that nothing is known of: a bug.
Failure failureOf(const std::exception_ptr& exception);

}  // namespace sheen
