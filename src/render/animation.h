// Frames of a scene that moves, one after the other, each as if it were rendered alone.
#pragma once

#include <optional>

#include "image/crop.h"
#include "render/render.h"
#include "scene/animation.h"

namespace sheen {

/// Renders a scene at one time after another. What did not change since the frame before is not
/// made again: where nothing did, the frame; where cameras did, whatever serves all views of a
/// scene (Session). Where geometry or lights did, all is.
class FrameSequence {
  public:
    /// The scene must outlive it and be moved by no one else. `part`: of the image, as
    /// renderPart() has it; none: all.
    FrameSequence(AnimatedScene& scene, const RenderParams& params, std::optional<Crop> part = {});

    /// The frame of that number at a time. The same bits as of a sequence that begins with it.
    /// Methods that trace paths take the number into their seed, so that the noise of two frames is
    /// independent. Errors as AnimatedScene::moveTo() and Session::render(). Valid until the next.
    const RenderResult& render(int number, double seconds);

    /// What was different in the frame rendered last from the one before; of the first: the scene.
    SceneChange change() const { return change_; }

  private:
    AnimatedScene& scene_;
    const RenderParams params_;
    const std::optional<Crop> part_;
    std::unique_ptr<Session> session_;
    std::optional<RenderResult> last_;
    SceneChange change_ = SceneChange::kScene;
};

}  // namespace sheen
