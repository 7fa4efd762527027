// A live image on a thread of its own, so that the window answers while records are gathered.
#pragma once

#include <atomic>
#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "core/failure.h"
#include "core/timer.h"
#include "image/tonemap.h"
#include "render/live.h"

namespace sheen {

/// What of the image is shown.
enum class Channel {
    kImage,
    kDirect,
    kIndirect,
    kAlbedo,
    kNormal,
    kDepth,
    kRoughness,
    kWeight,
    kError,
    kOrder
};

struct DisplaySettings {
    std::optional<float> exposure;  ///< stops; none: by the image when it is complete
    ToneCurve tone = ToneCurve::kNeutral;
    float direct = 1.0f, indirect = 1.0f;  ///< weights
    Channel channel = Channel::kImage;
    bool marks = false;  ///< whether records are to be marked

    bool operator==(const DisplaySettings&) const = default;
};

/// What the window shows; never changes.
struct Shown {
    Image<Rgb8> pixels;
    LiveProgress progress;
    Camera camera;
    float exposure = 0.0f;  ///< stops that it was shown with
    bool complete = false;  ///< LiveProgress::complete, and faded in
    std::vector<LiveMark> marks;
    double at = 0.0;  ///< seconds since the thread began
    int number = 0;   ///< of the step; what fades in, or is shown otherwise, is of the same
};

/// Jobs that replace each other (LiveThread::post()).
enum JobKey { kNoKey = 0, kCameraJob, kParamsJob, kLightsJob, kMaterialsJob, kPickJob };

class LiveThread {
  public:
    /// `budget`: seconds of a step.
    LiveThread(std::unique_ptr<LiveImage> image, double budget);
    ~LiveThread();
    LiveThread(const LiveThread&) = delete;
    LiveThread& operator=(const LiveThread&) = delete;

    /// Runs a job between two steps; of those not yet run of the same key, other than kNoKey, the
    /// last one alone. What it throws is kept for failure().
    void post(std::function<void(LiveImage&)> job, JobKey key = kNoKey);
    void display(const DisplaySettings& settings);

    /// Asks what a place's light is made of (LiveImage::partsAt()), for picked().
    void pick(const vec2& place);
    /// What was asked for last; null before the first, and where there is no image.
    std::shared_ptr<const PixelParts> picked() const;

    /// The newest; null before the first.
    std::shared_ptr<const Shown> shown() const;
    /// Whether nothing is left to be done.
    bool idle() const;
    /// What went wrong last, once.
    std::optional<Failure> failure();

  private:
    struct Job {
        std::function<void(LiveImage&)> run;
        JobKey key;
    };
    void work();
    void runJobs(std::vector<Job> jobs);
    void keepFailure();
    bool show(const DisplaySettings& settings);

    const std::unique_ptr<LiveImage> image_;
    const double budget_;
    const Timer timer_;
    mutable std::mutex mutex_;
    std::condition_variable wake_;
    std::vector<Job> jobs_;
    DisplaySettings settings_;
    bool redisplay_ = false, stopping_ = false, idle_ = false;
    std::atomic<bool> outdated_ = false;  // what is shown, by jobs that wait
    std::shared_ptr<const Shown> shown_;
    std::shared_ptr<const PixelParts> picked_;
    std::optional<Failure> failure_;
    // The thread's own.
    Image<vec3> seen_;  // as it is shown: follows the image in small steps
    Camera seen_by_;
    float exposure_ = 0.0f;
    bool exposed_ = false;
    int steps_ = 0;
    std::thread thread_;
};

}  // namespace sheen
