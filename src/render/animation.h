// Frames of a scene that moves, one after the other.
#pragma once

#include <deque>
#include <limits>
#include <memory>
#include <optional>
#include <vector>

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
    /// Records stay, and are followed by what their rays met (gather/strata.h). Not with
    /// `temporal`.
    bool anchors = false;
    /// Where temporal gradients are interpolated: no frame after it is looked at.
    int last = std::numeric_limits<int>::max();
};

/// Renders a scene at one time after another. What did not change since the frame before is not
/// made again: where nothing did, the frame; where cameras did, whatever serves all views of a
/// scene (Session). Where geometry or lights did, all is, but for records that live on.
/// Where their temporal gradients are interpolated, records are gathered ahead of images, until it
/// is known what comes after those that the frame has: twice as long as they live, at the most.
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
    // A record that lives in a frame.
    struct Living {
        std::shared_ptr<const Life> life;
        int age = 0;
    };
    // A frame whose records are gathered, and whose image is not made yet.
    struct GatheredFrame {
        int number = 0;
        SceneChange change = SceneChange::kScene;
        bool same = false;  // as the one before: nothing was gathered
        std::vector<Living> records = {};
        int gather_size = 0;  // of records
        RenderStats stats = {};
    };
    SceneChange moveTo(int number);
    KeptRecords keptFor(int number, SceneChange change);
    bool keepsRecords() const { return sequence_.temporal || sequence_.anchors; }
    Ageing ageingAt(int number, SceneChange change);
    Ageing beginAnchors(int number, SceneChange change, const KeptRecords& kept);
    RenderParams paramsAt(int number) const;
    RenderResult image(int number);
    const RenderResult& renderAtOnce(int number);
    const RenderResult& renderGathered(int number);
    void lookAhead(int number);
    void gather(int number);
    bool knowsWhatComes() const;

    AnimatedScene& scene_;
    const RenderParams params_;
    const SequenceParams sequence_;
    int at_ = 0;  // the frame that the scene was moved to last
    std::unique_ptr<Session> session_;
    std::optional<RenderResult> last_;
    std::optional<Places> places_;      // of the frame whose records were gathered last
    KeptRecords kept_;                  // likewise
    std::shared_ptr<Anchors> anchors_;  // of those
    size_t anchors_used_ = 0;           // when they were counted last
    std::deque<GatheredFrame> ahead_;
    SceneChange change_ = SceneChange::kScene;
};

}  // namespace sheen
