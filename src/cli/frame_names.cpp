#include "cli/frame_names.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <filesystem>
#include <optional>

#include "core/error.h"

namespace sheen::cli {
namespace {

namespace fs = std::filesystem;

constexpr int kMostFrames = 1'000'000;
constexpr size_t kMostDigits = 9;

std::optional<int> frameNumber(std::string_view text) {
    int number = 0;
    const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), number);
    const bool whole = error == std::errc() && stop == text.data() + text.size();
    return whole && number >= 0 && number < kMostFrames ? std::optional<int>(number) : std::nullopt;
}

}  // namespace

std::string FrameNames::operator()(int frame) const {
    return fmt::format("{}{:0{}}{}", before, frame, digits, after);
}

bool countsFrames(const std::string& pattern) { return pattern.find('%') != std::string::npos; }

FrameNames parseFrameNames(const std::string& option, const std::string& pattern) {
    const auto fail = [&] {
        throwUsage("{} {}: the file's name must count frames once, as in frame_%04d.exr", option,
                   pattern);
    };
    const size_t percent = pattern.find('%');
    const size_t d = pattern.find('d', percent == std::string::npos ? 0 : percent);
    const size_t slash = pattern.rfind('/');
    if (percent == std::string::npos || d == std::string::npos ||
        pattern.find('%', d) != std::string::npos ||
        (slash != std::string::npos && percent < slash)) {
        fail();
    }
    const std::string width = pattern.substr(percent + 1, d - percent - 1);
    const bool filled = width.size() == 2 && width[0] == '0' && width[1] >= '1' &&
                        width[1] <= static_cast<char>('0' + kMostDigits);
    if (!width.empty() && !filled) {
        fail();
    }
    return {.before = pattern.substr(0, percent),
            .after = pattern.substr(d + 1),
            .digits = filled ? width[1] - '0' : 1};
}

std::vector<int> framesThere(const FrameNames& names) {
    const fs::path before(names.before);
    const fs::path folder = before.has_parent_path() ? before.parent_path() : fs::path(".");
    const std::string start = before.filename().string();
    std::vector<int> numbers;
    std::error_code error;
    for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
         entry.increment(error)) {
        const std::string name = entry->path().filename().string();
        if (name.size() <= start.size() + names.after.size() || !name.starts_with(start) ||
            !name.ends_with(names.after)) {
            continue;
        }
        const std::optional<int> number = frameNumber(std::string_view(name).substr(
            start.size(), name.size() - start.size() - names.after.size()));
        if (number && fs::path(names(*number)).filename() == name) {
            numbers.push_back(*number);
        }
    }
    std::sort(numbers.begin(), numbers.end());
    return numbers;
}

FrameRange parseFrames(const std::string& text) {
    const size_t dots = text.find("..");
    const std::optional<int> first = frameNumber(text.substr(0, dots));
    const std::optional<int> last =
        dots == std::string::npos ? first : frameNumber(text.substr(dots + 2));
    if (!first || !last || *last < *first) {
        throwUsage("--frames {}: must be FIRST..LAST, whole numbers from 0 on, as in 0..47", text);
    }
    return {*first, *last};
}

}  // namespace sheen::cli
