#include "render/animation.h"

#include "core/timer.h"
#include "render/crop.h"

namespace sheen {

FrameSequence::FrameSequence(AnimatedScene& scene, const RenderParams& params,
                             std::optional<Crop> part)
    : scene_(scene), params_(params), part_(part) {}

const RenderResult& FrameSequence::render(int number, double seconds) {
    const Timer timer;
    const SceneChange moved = scene_.moveTo(seconds);
    change_ = session_ ? moved : SceneChange::kScene;
    if (change_ == SceneChange::kScene) {
        session_.reset();  // what it holds was made of what is gone
        session_ = std::make_unique<Session>(scene_.scene());
    }
    const bool traced = params_.method == Method::kReference || params_.method == Method::kDenoised;
    if (!last_ || change_ != SceneChange::kNothing || traced) {
        RenderParams params = params_;
        params.seed += static_cast<uint32_t>(number);
        last_ = part_ ? renderPart(*session_, params, *part_) : session_->render(params);
    } else {
        last_->stats.seconds = {};
    }
    last_->stats.seconds.total = timer.seconds();
    return *last_;
}

}  // namespace sheen
