#include "render/animation.h"

#include <cstring>
#include <utility>

#include "core/timer.h"
#include "render/crop.h"

namespace sheen {
namespace {

bool sameTriangles(const std::vector<uvec3>& a, const std::vector<uvec3>& b) {
    return a.size() == b.size() &&
           (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(uvec3)) == 0);
}

}  // namespace

FrameSequence::FrameSequence(AnimatedScene& scene, const RenderParams& params,
                             const SequenceParams& sequence)
    : scene_(scene), params_(params), sequence_(sequence) {}

// What moved since the frame before, whose triangles were the same, and what will until the next.
Ageing FrameSequence::ageingAt(int number) {
    Ageing ageing{.params = *sequence_.temporal};
    const Scene& scene = scene_.scene();
    if (change_ == SceneChange::kScene && places_) {
        ageing.moved = movedTriangles(scene, places_->positions);
    }
    const auto next = scene_.positionsAt((number + 1) / sequence_.fps);
    // Where it cannot be told which surface is which, none is taken to move.
    ageing.coming = std::make_shared<const Motion>(scene, next ? *next : scene.positions);
    return ageing;
}

// Records of the frame before, for this one; none where it is not the next, or where it cannot be
// told which surface is which.
KeptRecords FrameSequence::keptFor(int number, KeptRecords kept) {
    const Scene& scene = scene_.scene();
    if (places_ &&
        (places_->frame + 1 != number || !sameTriangles(places_->triangles, scene.triangles))) {
        places_.reset();
    }
    if (!places_) {
        kept = {};
    }
    kept.forgetEnded();
    kept.beginFrame(ageingAt(number), change_ == SceneChange::kScene);
    places_ = Places{number, scene.positions, scene.triangles};
    return kept;
}

const RenderResult& FrameSequence::render(int number) {
    const Timer timer;
    const SceneChange moved = scene_.moveTo(number / sequence_.fps);
    change_ = session_ ? moved : SceneChange::kScene;
    const bool traced = params_.method == Method::kReference || params_.method == Method::kDenoised;
    if (last_ && change_ == SceneChange::kNothing && !traced) {
        last_->stats.seconds = {.total = timer.seconds()};
        if (places_) {
            places_->frame = number;
        }
        return *last_;
    }
    KeptRecords kept = session_ ? session_->takeRecords() : KeptRecords();
    if (change_ == SceneChange::kScene) {
        session_.reset();  // what it holds was made of what is gone
        session_ = std::make_unique<Session>(scene_.scene());
    }
    if (sequence_.temporal) {
        session_->keepRecords(keptFor(number, std::move(kept)), recordRecipe(params_));
    }
    RenderParams params = params_;
    params.seed += static_cast<uint32_t>(number);
    last_ =
        sequence_.part ? renderPart(*session_, params, *sequence_.part) : session_->render(params);
    last_->stats.seconds.total = timer.seconds();
    return *last_;
}

}  // namespace sheen
