// Names of the images of a sequence, which count their frames: out/frame_%04d.exr.
#pragma once

#include <string>
#include <vector>

namespace sheen::cli {

/// What a pattern says, around its number.
struct FrameNames {
    std::string before = {}, after = {};
    int digits = 0;  ///< at least; filled up with zeros

    std::string operator()(int frame) const;
    /// A file that belongs to the sequence as a whole: `name` where the number stands.
    std::string beside(const std::string& name) const { return before + name; }
};

/// Whether a name counts anything.
bool countsFrames(const std::string& pattern);

/// "..%d.." or "..%04d..", in the file's name. Usage error otherwise, which names the option.
FrameNames parseFrameNames(const std::string& option, const std::string& pattern);

/// The numbers of the frames that are there, growing.
std::vector<int> framesThere(const FrameNames& names);

/// "A..B" or "A": the first and the last frame. Usage error otherwise.
struct FrameRange {
    int first = 0, last = 0;
};
FrameRange parseFrames(const std::string& text);

}  // namespace sheen::cli
