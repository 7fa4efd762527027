// What a sequence of images was made of, in a file beside them: so that one which is continued is
// continued with the same.
#pragma once

#include <optional>
#include <string>

#include "cli/frame_names.h"

namespace sheen::cli {

struct SequenceKey {
    std::string program;  ///< name and version
    std::string scene;    ///< hash of the files that were read
    std::string options;  ///< that change images
    bool operator==(const SequenceKey&) const = default;
};

/// What is known of a sequence that was begun.
struct Sequence {
    SequenceKey key;
    std::optional<float> exposure = {};  ///< stops, of all its PNGs
};

/// Reads what is beside images of these names. None where the sequence has not been begun. Usage
/// error where it has, by another key, or where one of the frames `first` to `last` is there all
/// the same.
std::optional<Sequence> findSequence(const FrameNames& names, const FrameRange& frames,
                                     const SequenceKey& key);

/// Writes it. Environment error where that cannot be.
void writeSequence(const FrameNames& names, const Sequence& sequence);

/// The file's name.
std::string sequenceFile(const FrameNames& names);

}  // namespace sheen::cli
