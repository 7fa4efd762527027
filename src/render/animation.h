// Frames of a scene that moves, one after the other.
#pragma once

#include <optional>

#include "cache/ageing.h"
#include "image/crop.h"
#include "render/render.h"
#include "scene/animation.h"

namespace sheen {

/// What frames of a sequence are, besides how each is rendered.
struct SequenceParams {
    std::optional<Crop> part = {};  ///< of the image, as renderPart() has it; none: all
    double fps = 24.0;              ///< frame n is at n / fps seconds
    /// Records live for some frames: each then depends on those before it. None: each frame is as
    /// if it were rendered alone.
    std::optional<TemporalParams> temporal = {};
};

/// Renders a scene at one time after another. What did not change since the frame before is not
/// made again: where nothing did, the frame; where cameras did, whatever serves all views of a
/// scene (Session). Where geometry or lights did, all is, but for records that live on.
class FrameSequence {
  public:
    /// The scene must outlive it and be moved by no one else.
    FrameSequence(AnimatedScene& scene, const RenderParams& params, const SequenceParams& sequence);

    /// A frame. The same bits, unless records live on, as of a sequence that begins with it.
    /// Methods that trace paths take the number into their seed, so that the noise of two frames is
    /// independent. Errors as AnimatedScene::moveTo() and Session::render(). Valid until the next.
    const RenderResult& render(int number);

    /// What was different in the frame rendered last from the one before; of the first: the scene.
    SceneChange change() const { return change_; }

  private:
    // Where surfaces were in a frame.
    struct Places {
        int frame = 0;
        std::vector<vec3> positions;
        std::vector<uvec3> triangles;
    };
    KeptRecords keptFor(int number, KeptRecords kept);
    Ageing ageingAt(int number);

    AnimatedScene& scene_;
    const RenderParams params_;
    const SequenceParams sequence_;
    std::unique_ptr<Session> session_;
    std::optional<RenderResult> last_;
    std::optional<Places> places_;  // of the frame before
    SceneChange change_ = SceneChange::kScene;
};

}  // namespace sheen
