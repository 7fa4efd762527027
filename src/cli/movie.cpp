#include "cli/movie.h"

#include <fmt/format.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <sstream>

#include "chart/child.h"
#include "core/error.h"

namespace sheen::cli {
namespace {

namespace fs = std::filesystem;

// A name as ffmpeg's patterns have it, in which % counts.
std::string escaped(const std::string& text) {
    std::string result;
    for (const char c : text) {
        result += c == '%' ? "%%" : std::string(1, c);
    }
    return result;
}

}  // namespace

std::string findFfmpeg(const std::string& for_movie) {
    const char* path = std::getenv("PATH");
    std::istringstream folders(path != nullptr ? path : "");
    for (std::string folder; std::getline(folders, folder, ':');) {
        const std::string program = (fs::path(folder) / "ffmpeg").string();
        if (!folder.empty() && access(program.c_str(), X_OK) == 0) {
            return program;
        }
    }
    throwEnvironment(
        "-o {}: movies are made by ffmpeg, which is not installed; install it, or write images: "
        "-o frame_%04d.png",
        for_movie);
}

void writeMovie(const std::string& ffmpeg, const FrameNames& names, const FrameRange& frames,
                double fps, const std::string& movie) {
    const std::string unfinished = names.beside("unfinished.mp4");
    const std::string pattern =
        fmt::format("{}%0{}d{}", escaped(names.before), names.digits, escaped(names.after));
    // Frames of any size; most players want even ones, and colours in half the resolution.
    runChild({ffmpeg, "-nostdin", "-loglevel", "error", "-y", "-framerate", fmt::format("{}", fps),
              "-start_number", std::to_string(frames.first), "-i", pattern, "-frames:v",
              std::to_string(frames.last - frames.first + 1), "-vf",
              "pad=ceil(iw/2)*2:ceil(ih/2)*2", "-pix_fmt", "yuv420p", unfinished},
             {});
    std::error_code error;
    fs::rename(unfinished, movie, error);
    if (error) {
        throwEnvironment("{}: cannot be written: {}", movie, error.message());
    }
}

}  // namespace sheen::cli
