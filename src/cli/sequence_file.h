// What a sequence of images was made of, in a file beside them: so that one which is continued is
// continued with the same. And what anything is made of that several processes make.
#pragma once

#include <CLI/CLI.hpp>
#include <optional>
#include <string>

#include "cli/frame_names.h"
#include "scene/scene.h"

namespace sheen::cli {

struct SequenceKey {
    std::string program;  ///< name and version
    std::string scene;    ///< hash of the files that were read
    std::string options;  ///< that change images
    bool operator==(const SequenceKey&) const = default;
};

/// The file of the program `sheen` that is running, even where it was moved since; also where this
/// process is `sheen-mpi`, which does the same.
std::string ownProgram();

/// What of the options changes results, as they were given.
std::string optionsText(const CLI::App& app);

/// The key of what these options make of the scene.
SequenceKey keyOf(const CLI::App& app, const Scene& scene);

/// The key as text, of what goes to `output`: what ranks that share it out must agree upon.
std::string jobText(const SequenceKey& key, const std::string& output);

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
