// How fast the window is: a camera that flies a path which is always the same.
#pragma once

#include "viewer/camera_control.h"
#include "viewer/live_thread.h"
#include "viewer/viewer.h"

namespace sheen {

/// Flies and measures: first the image as it stands, then the path twice.
class Benchmark {
  public:
    Benchmark(int frames, const CameraControl& start) : frames_(frames), start_(start) {}

    /// To be called once for each new image; whether it is over.
    bool follow(const Shown& shown, LiveThread& live);
    const ViewerFigures& figures() const { return figures_; }

  private:
    void begin(const Shown& shown, LiveThread& live);
    void go(LiveThread& live) const;

    const int frames_;
    const CameraControl start_;
    ViewerFigures figures_;
    int phase_ = 0, frame_ = 0;
    double began_ = 0.0;
    int steps_ = 0;      // of the last flight
    int last_step_ = 0;  // Shown::number of the last of them
};

}  // namespace sheen
