// Two folders of images side by side, as a page to look at.
#pragma once

#include <string>

#include "core/error.h"

namespace sheen::cli {

/// Writes the page of all EXR files whose names both folders have, and, to `json`, their figures
/// (writeJson()). The page needs no network and no other file. An image that cannot be judged is on
/// it with the reason, and makes the exit code that of bad input. Input error where there are no
/// such files.
ExitCode comparePage(const std::string& tests, const std::string& references,
                     const std::string& layer, const std::string& page, const std::string& json);

}  // namespace sheen::cli
