#include "viewer/benchmark.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace sheen {
namespace {

// The camera of frame i of `count`: a curve about what is looked at.
Camera onPath(CameraControl control, int i, int count) {
    const float t = 2.0f * kPi * static_cast<float>(i) / static_cast<float>(count);
    control.orbit(0.4f * std::sin(t), 0.1f * std::sin(2.0f * t));
    return control.camera();
}

}  // namespace

bool Benchmark::follow(const Shown& shown, LiveThread& live) {
    if (figures_.seconds_to_first == 0.0) {
        figures_.seconds_to_first = shown.at;
    }
    figures_.records = std::max(figures_.records, shown.progress.records);
    if (phase_ == 0) {
        if (!shown.complete) {
            return false;
        }
        figures_.seconds_to_full = shown.at;
        begin(shown, live);
        return false;
    }
    if (phase_ == 2 && std::exchange(last_step_, shown.number) != shown.number) {
        ++steps_;
        for (const Stage& stage : kStages) {
            figures_.stages.*stage.seconds += shown.progress.seconds.*stage.seconds;
        }
        figures_.stages.total += shown.progress.seconds.total;
    }
    if (++frame_ <= frames_) {
        go(live);
        return false;
    }
    (phase_ == 1 ? figures_.fps_fill : figures_.fps_full) =
        static_cast<double>(frames_) / std::max(shown.at - began_, 1e-9);
    if (phase_ == 2) {
        for (const Stage& stage : kStages) {
            figures_.stages.*stage.seconds /= steps_;
        }
        figures_.stages.total /= steps_;
        return true;
    }
    begin(shown, live);
    return false;
}

void Benchmark::begin(const Shown& shown, LiveThread& live) {
    ++phase_;
    frame_ = 1;
    began_ = shown.at;
    go(live);
}

void Benchmark::go(LiveThread& live) const {
    const Camera camera = onPath(start_, frame_, frames_);
    live.post([camera](LiveImage& image) { image.look(camera); }, kCameraJob);
}

}  // namespace sheen
