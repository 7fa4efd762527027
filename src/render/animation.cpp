#include "render/animation.h"

#include <algorithm>
#include <cstring>
#include <functional>
#include <utility>

#include "cache/temporal.h"
#include "core/timer.h"
#include "gather/strata.h"
#include "render/crop.h"

namespace sheen {
namespace {

// To the figures of an image those of its records. What the image itself lacked counts as new.
void addGathered(const RenderStats& gathered, RenderStats& stats) {
    stats.records_reused += gathered.records_reused - gathered.records;
    stats.records_renewed = gathered.records_renewed;
    for (const Stage& stage : kStages) {
        stats.seconds.*stage.seconds += gathered.seconds.*stage.seconds;
    }
}

bool sameTriangles(const std::vector<uvec3>& a, const std::vector<uvec3>& b) {
    return a.size() == b.size() &&
           (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(uvec3)) == 0);
}

}  // namespace

FrameSequence::FrameSequence(AnimatedScene& scene, const RenderParams& params,
                             const SequenceParams& sequence)
    : scene_(scene), params_(params), sequence_(sequence) {}

// Also makes the session anew where what it holds was made of what is gone.
SceneChange FrameSequence::moveTo(int number) {
    const SceneChange moved = scene_.moveTo(number / sequence_.fps);
    at_ = number;
    if (session_ && moved != SceneChange::kScene) {
        return moved;
    }
    session_.reset();
    // Once records are known few are gathered. Anchors find light in the same way in all frames.
    const bool few = places_ || sequence_.anchors;
    session_ = std::make_unique<Session>(scene_.scene(), RankedJob{},
                                         few ? RaysWanted::kFew : RaysWanted::kMany);
    return SceneChange::kScene;
}

// What moved since the frame before, whose triangles were the same, and what will until the next.
Ageing FrameSequence::ageingAt(int number, SceneChange change) {
    Ageing ageing{.params = *sequence_.temporal};
    const Scene& scene = scene_.scene();
    if (change == SceneChange::kScene && places_) {
        ageing.moved = movedTriangles(scene, places_->positions);
    }
    const auto next = scene_.positionsAt((number + 1) / sequence_.fps);
    // Where it cannot be told which surface is which, none is taken to move.
    ageing.coming = std::make_shared<const Motion>(scene, next ? *next : scene.positions);
    return ageing;
}

// Begins a frame for anchors. Unused ones are dropped now and then.
Ageing FrameSequence::beginAnchors(int number, SceneChange change, const KeptRecords& kept) {
    constexpr size_t kFew = 4096;
    const bool stands = change != SceneChange::kScene;
    Ageing ageing{.anchors = anchors_, .stands = stands};
    if (stands) {
        return ageing;
    }
    const Scene& scene = scene_.scene();
    std::vector<uint8_t> moves(scene.triangles.size(), 0);
    if (places_) {
        ageing.moved = movedTriangles(scene, places_->positions);
        moves = ageing.moved;
    }
    if (const auto next = scene_.positionsAt((number + 1) / sequence_.fps)) {
        const std::vector<uint8_t> will = movedTriangles(scene, *next);
        std::transform(moves.begin(), moves.end(), will.begin(), moves.begin(), std::bit_or<>());
    }
    std::vector<Strata*> strata;
    size_t rays = 0;
    for (const GatheredRecord& found : kept.records()) {
        if (found.strata) {
            strata.push_back(found.strata.get());
            rays += found.strata->anchors.size();
        }
    }
    if (anchors_->size() >= std::min(2 * anchors_used_ + kFew, Anchors::kMost)) {
        dropUnused(*anchors_, strata);
        anchors_used_ = anchors_->size();
    }
    anchors_->beginFrame(
        scene, std::move(moves),
        places_ ? std::span<const vec3>(places_->positions) : std::span<const vec3>(), rays);
    return ageing;
}

// Records of the frame before, for this one; none where it is not the next, or where it cannot be
// told which surface is which.
KeptRecords FrameSequence::keptFor(int number, SceneChange change) {
    KeptRecords kept = std::exchange(kept_, {});
    const Scene& scene = scene_.scene();
    if (places_ &&
        (places_->frame + 1 != number || !sameTriangles(places_->triangles, scene.triangles))) {
        places_.reset();
    }
    if (!places_) {
        kept = {};
        anchors_ = sequence_.anchors ? std::make_shared<Anchors>() : nullptr;
        anchors_used_ = 0;
    }
    if (sequence_.anchors) {
        if (change == SceneChange::kScene) {
            kept.dropToLatest(kept.latest().size());  // what nobody saw was not followed
        }
        kept.beginFrame(beginAnchors(number, change, kept), false);
    } else {
        kept.forgetEnded();
        kept.beginFrame(ageingAt(number, change), change == SceneChange::kScene);
    }
    places_ = Places{number, scene.positions, scene.triangles};
    return kept;
}

RenderParams FrameSequence::paramsAt(int number) const {
    RenderParams params = params_;
    params.seed += static_cast<uint32_t>(number);
    return params;
}

RenderResult FrameSequence::image(int number) {
    const RenderParams params = paramsAt(number);
    return sequence_.part ? renderPart(*session_, params, *sequence_.part)
                          : session_->render(params);
}

const RenderResult& FrameSequence::render(int number) {
    const bool interpolates =
        sequence_.temporal && sequence_.temporal->gradients == TemporalGradients::kInterpolated;
    return interpolates ? renderGathered(number) : renderAtOnce(number);
}

const RenderResult& FrameSequence::renderAtOnce(int number) {
    const Timer timer;
    change_ = moveTo(number);
    const bool traced = params_.method == Method::kReference || params_.method == Method::kDenoised;
    if (last_ && change_ == SceneChange::kNothing && !traced) {
        last_->stats.seconds = {.total = timer.seconds()};
        if (places_) {
            places_->frame = number;
        }
        return *last_;
    }
    if (keepsRecords()) {
        session_->keepRecords(keptFor(number, change_), recordRecipe(params_));
    }
    last_ = image(number);
    if (keepsRecords()) {
        kept_ = session_->takeRecords();
    }
    last_->stats.seconds.total = timer.seconds();
    return *last_;
}

// ---- Temporal gradients that are interpolated: records first, then images -----------------------

// Gathers a frame's records, the next of `ahead_`.
void FrameSequence::gather(int number) {
    const Timer timer;
    if (places_ && places_->frame + 1 == number && at_ != places_->frame) {
        moveTo(places_->frame);  // with which it is compared
    }
    GatheredFrame frame{.number = number, .change = moveTo(number)};
    frame.same = frame.change == SceneChange::kNothing && places_ && places_->frame + 1 == number;
    if (frame.same) {
        places_->frame = number;
    } else {
        session_->keepRecords(keptFor(number, frame.change), recordRecipe(params_));
        const RenderParams params = paramsAt(number);
        frame.stats =
            session_->gather(sequence_.part ? paramsOfPart(params, *sequence_.part) : params);
        kept_ = session_->takeRecords();
        for (const GatheredRecord& found : kept_.latest()) {
            frame.records.push_back({found.life, found.age});
        }
        frame.gather_size = kept_.gatherSize();
    }
    frame.stats.seconds.total = timer.seconds();
    ahead_.push_back(std::move(frame));
}

// Whether all that the first frame ahead has will have ended, but for what lives beyond the last.
bool FrameSequence::knowsWhatComes() const {
    const auto ages = std::count_if(
        ahead_.begin() + 1, ahead_.end(),
        [](const GatheredFrame& frame) { return frame.change == SceneChange::kScene; });
    return ahead_.back().number >= sequence_.last || ages >= sequence_.temporal->longest;
}

// Makes the frame the first of those ahead, and gathers what comes: twice as much as is needed,
// since the scene must go back and forth in between.
void FrameSequence::lookAhead(int number) {
    if (ahead_.empty() || number < ahead_.front().number || number > ahead_.back().number) {
        ahead_.clear();
        gather(number);
    }
    while (ahead_.front().number != number) {
        GatheredFrame skipped = std::move(ahead_.front());
        ahead_.pop_front();
        if (ahead_.front().same) {
            skipped.number = ahead_.front().number;
            ahead_.front() = std::move(skipped);
        }
    }
    if (knowsWhatComes()) {
        return;
    }
    for (int block = 0; block < sequence_.temporal->longest || !knowsWhatComes(); ++block) {
        if (ahead_.back().number >= sequence_.last) {
            return;
        }
        gather(ahead_.back().number + 1);
    }
}

const RenderResult& FrameSequence::renderGathered(int number) {
    lookAhead(number);
    const Timer timer;
    const GatheredFrame frame = std::move(ahead_.front());
    ahead_.pop_front();
    change_ = frame.change;
    const double gathered_in = frame.stats.seconds.total;
    if (frame.same && last_) {
        last_->stats.seconds = {.total = gathered_in};
        return *last_;
    }
    moveTo(number);
    RecordField field;
    for (const Living& living : frame.records) {
        field.records.push_back(recordAt(*living.life, living.age));
    }
    field.gather_size = frame.gather_size;
    KeptRecords records;
    records.put(std::move(field));
    session_->keepRecords(std::move(records), recordRecipe(params_));
    last_ = image(number);
    session_->takeRecords();
    addGathered(frame.stats, last_->stats);
    last_->stats.seconds.total = gathered_in + timer.seconds();
    return *last_;
}

}  // namespace sheen
