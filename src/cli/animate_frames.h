// The frames of a sequence as units of work: each is rendered and written by whoever takes it.
#pragma once

#include <string>
#include <vector>

#include "cli/output.h"
#include "cli/render_options.h"
#include "cli/sequence_file.h"
#include "core/ranks.h"
#include "render/animation.h"

namespace sheen::cli {

/// Where frames go.
struct FrameFiles {
    FrameNames names = {};
    FileKind kind = FileKind::kExr;
};

/// The frames of the range that are not there, or cannot be read to their end; these are warned of.
std::vector<int> missingFrames(const FrameFiles& files, const FrameRange& frames);

/// Renders frames of a sequence, and writes them.
class FrameMaker {
  public:
    /// `sequence`: what is known of it. All must outlive it.
    FrameMaker(const RenderOptions& options, const FrameFiles& files, AnimatedScene& scene,
               const SequenceParams& params, const Sequence& sequence);

    /// Has these frames made by all ranks, and returns each one's figures, in their order. Of PNGs
    /// whose exposure is not known the first is made before the others, which take its exposure.
    std::vector<Json> make(Ranks& ranks, const std::string& job, const std::vector<int>& frames);
    /// Makes those that the first rank asks for.
    void serve(Ranks& ranks, const std::string& job);

  private:
    std::string makeOne(const std::string& unit);
    std::string unitOf(int frame) const;
    void fixExposure(const Frame& frame);
    void write(const RenderResult& result) const;
    void sayNewWarnings();

    RenderOptions options_;  // `output`: the frame that is made
    const FrameFiles& files_;
    AnimatedScene& scene_;
    Sequence sequence_;
    FrameSequence renderer_;
    size_t warnings_said_;
};

}  // namespace sheen::cli
