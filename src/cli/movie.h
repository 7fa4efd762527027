// A movie of a sequence's frames, by ffmpeg.
#pragma once

#include <string>

#include "cli/frame_names.h"

namespace sheen::cli {

/// Where the program ffmpeg is. Environment error where it is not installed.
std::string findFfmpeg(const std::string& for_movie);

/// Writes `movie`, which appears whole or not at all, of PNG frames that are all there. Environment
/// error where ffmpeg fails.
void writeMovie(const std::string& ffmpeg, const FrameNames& names, const FrameRange& frames,
                double fps, const std::string& movie);

}  // namespace sheen::cli
