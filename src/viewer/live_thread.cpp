#include "viewer/live_thread.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <exception>
#include <utility>

#include "core/error.h"
#include "core/parallel.h"

namespace sheen {
namespace {

// In a step that changes neither view nor size no pixel changes by more than this share of its
// value, or of the image's mean where it is darker: new records fade in.
constexpr float kFade = 0.15f;

bool sameView(const Camera& a, const Camera& b) {
    return a.world_from_camera == b.world_from_camera && a.y_fov == b.y_fov;
}

// Moves `seen` toward `wanted` by at most a share of each pixel. Whether it has arrived.
bool fade(const Image<vec3>& wanted, Image<vec3>& seen) {
    float mean = 0.0f;
    for (const vec3& v : wanted.pixels) {
        mean += finite(v) ? luminance(v) : 0.0f;
    }
    mean /= static_cast<float>(std::max<size_t>(wanted.pixels.size(), 1));
    bool arrived = true;
    for (size_t i = 0; i < wanted.pixels.size(); ++i) {
        const vec3 step = wanted.pixels[i] - seen.pixels[i];
        const float most = std::max(luminance(seen.pixels[i]), mean);
        const float length = std::max({std::abs(step.x), std::abs(step.y), std::abs(step.z)});
        // All at once where everything goes dark, and where there is no number.
        if (!(length > kFade * most) || !(mean > 0.0f) || !finite(step)) {
            seen.pixels[i] = wanted.pixels[i];
            continue;
        }
        seen.pixels[i] += step * (kFade * most / length);
        arrived = false;
    }
    return arrived;
}

Image<vec3> grey(const Image<float>& values, float white) {
    Image<vec3> image(values.width, values.height);
    for (size_t i = 0; i < values.pixels.size(); ++i) {
        image.pixels[i] = vec3(std::min(values.pixels[i] / white, 1.0f));
    }
    return image;
}

float greatestFinite(const Image<float>& values) {
    float greatest = 0.0f;
    for (const float v : values.pixels) {
        greatest = std::isfinite(v) ? std::max(greatest, v) : greatest;
    }
    return greatest > 0.0f ? greatest : 1.0f;
}

// White: a tenth of the mean of the indirect light, or more. Black before it is known.
Image<vec3> errorOf(const Frame& frame) {
    constexpr float kWhite = 0.1f;
    float sum = 0.0f;
    for (const vec3& light : frame.indirect.pixels) {
        sum += luminance(light);
    }
    const auto count = static_cast<float>(std::max<size_t>(frame.indirect.pixels.size(), 1));
    if (frame.error.empty() || !(sum > 0.0f)) {
        return {frame.width(), frame.height()};
    }
    return grey(frame.error, kWhite * sum / count);
}

// Channels that are no light, as display values.
Image<vec3> channelOf(const LiveImage& image, Channel channel) {
    const Frame& frame = image.frame();
    switch (channel) {
        case Channel::kAlbedo:
            return frame.albedo;
        case Channel::kNormal: {
            Image<vec3> shown = frame.normal;
            for (vec3& n : shown.pixels) {
                n = n == vec3(0.0f) ? n : 0.5f * n + 0.5f;
            }
            return shown;
        }
        case Channel::kDepth:
            return grey(frame.depth, greatestFinite(frame.depth));
        case Channel::kRoughness:
            return grey(frame.roughness, 1.0f);
        case Channel::kWeight:
            return grey(frame.weight, greatestFinite(frame.weight));
        case Channel::kError:
            return errorOf(frame);
        case Channel::kOrder:
            return grey(image.orders(), static_cast<float>(shared::SH_MAX_ORDER));
        case Channel::kImage:
        case Channel::kDirect:
        case Channel::kIndirect:
            return {};
    }
    return {};
}

void addScaled(const Image<vec3>& layer, float factor, Image<vec3>& sum) {
    for (size_t i = 0; i < layer.pixels.size(); ++i) {
        sum.pixels[i] += factor * layer.pixels[i];
    }
}

Image<vec3> lightOf(const Frame& frame, const DisplaySettings& s) {
    Image<vec3> sum(frame.width(), frame.height());
    if (s.channel != Channel::kIndirect) {
        addScaled(frame.direct, s.direct, sum);
    }
    if (s.channel != Channel::kDirect) {
        addScaled(frame.indirect, s.indirect, sum);
        addScaled(frame.caustic, s.indirect, sum);
    }
    if (s.channel == Channel::kImage) {
        addScaled(frame.emission, 1.0f, sum);
    }
    return sum;
}

Image<Rgb8> displayed(const Image<vec3>& values) {
    Image<vec3> encoded = values;
    for (vec3& v : encoded.pixels) {
        v = finite(v) ? glm::clamp(v, vec3(0.0f), vec3(1.0f)) : vec3(1.0f, 0.0f, 1.0f);
    }
    return bytesFromDisplay(encoded);
}

}  // namespace

LiveThread::LiveThread(std::unique_ptr<LiveImage> image, double budget)
    : image_(std::move(image)), budget_(budget), thread_([this] { work(); }) {}

LiveThread::~LiveThread() {
    {
        const std::lock_guard<std::mutex> lock(mutex_);
        stopping_ = true;
        outdated_ = true;
    }
    wake_.notify_all();
    thread_.join();
}

void LiveThread::post(std::function<void(LiveImage&)> job, JobKey key) {
    {
        const std::lock_guard<std::mutex> lock(mutex_);
        if (key != kNoKey) {
            std::erase_if(jobs_, [key](const Job& other) { return other.key == key; });
        }
        jobs_.push_back({std::move(job), key});
        idle_ = false;
        outdated_ = outdated_ || (key != kNoKey && key != kPickJob);
    }
    wake_.notify_all();
}

void LiveThread::display(const DisplaySettings& settings) {
    {
        const std::lock_guard<std::mutex> lock(mutex_);
        if (settings == settings_) {
            return;
        }
        settings_ = settings;
        redisplay_ = true;
        idle_ = false;
    }
    wake_.notify_all();
}

void LiveThread::pick(const vec2& place) {
    post(
        [this, place](LiveImage& image) {
            std::optional<PixelParts> parts = image.partsAt(place);
            const std::lock_guard<std::mutex> lock(mutex_);
            picked_ = parts ? std::make_shared<const PixelParts>(std::move(*parts)) : nullptr;
        },
        kPickJob);
}

std::shared_ptr<const PixelParts> LiveThread::picked() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return picked_;
}

std::shared_ptr<const Shown> LiveThread::shown() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return shown_;
}

bool LiveThread::idle() const {
    const std::lock_guard<std::mutex> lock(mutex_);
    return idle_;
}

std::optional<Failure> LiveThread::failure() {
    const std::lock_guard<std::mutex> lock(mutex_);
    return std::exchange(failure_, std::nullopt);
}

// Of the exception that is being handled.
void LiveThread::keepFailure() {
    const std::lock_guard<std::mutex> lock(mutex_);
    failure_ = failureOf(std::current_exception());
}

void LiveThread::runJobs(std::vector<Job> jobs) {
    for (const Job& job : jobs) {
        try {
            job.run(*image_);
        } catch (...) {
            keepFailure();
        }
    }
}

// Steps as long as there is something to do. What goes wrong in one ends them until something is
// changed.
void LiveThread::work() {
    bool arrived = true, failed = false;
    while (true) {
        std::vector<Job> jobs;
        DisplaySettings settings;
        {
            std::unique_lock<std::mutex> lock(mutex_);
            const auto ready = [&] { return stopping_ || redisplay_ || !jobs_.empty(); };
            if ((image_->done() || failed) && arrived && !ready()) {
                idle_ = true;
                wake_.wait(lock, ready);
            }
            if (stopping_) {
                return;
            }
            jobs = std::exchange(jobs_, {});
            outdated_ = false;
            settings = settings_;
            redisplay_ = false;
        }
        failed = failed && jobs.empty();
        runJobs(std::move(jobs));
        try {
            if (!image_->done() && !failed) {
                if (!image_->step(budget_, &outdated_)) {
                    continue;
                }
                ++steps_;
            } else if (!arrived) {
                std::this_thread::sleep_for(std::chrono::duration<double>(budget_));
            }
            arrived = show(settings);
        } catch (...) {
            failed = arrived = true;
            keepFailure();
        }
    }
}

bool LiveThread::show(const DisplaySettings& settings) {
    auto shown = std::make_shared<Shown>();
    shown->progress = image_->progress();
    shown->camera = image_->camera();
    shown->number = steps_;
    if (settings.marks) {
        shown->marks = image_->marks();
    }
    const Image<vec3> channel = channelOf(*image_, settings.channel);
    bool arrived = true;
    if (!channel.empty()) {
        shown->pixels = displayed(channel);
    } else {
        const Image<vec3> wanted = lightOf(image_->frame(), settings);
        const bool same = seen_.width == wanted.width && seen_.height == wanted.height &&
                          sameView(seen_by_, image_->camera());
        if (same) {
            arrived = fade(wanted, seen_);
        } else {
            seen_ = wanted;
        }
        seen_by_ = image_->camera();
        if (!exposed_ || shown->progress.complete) {
            exposure_ = autoExposure(wanted);
            exposed_ = true;
        }
        shown->exposure = settings.exposure.value_or(exposure_);
        shown->pixels = displayImage(seen_, shown->exposure, toSrgb(settings.tone));
    }
    shown->complete = shown->progress.complete && arrived;
    shown->at = timer_.seconds();
    const std::lock_guard<std::mutex> lock(mutex_);
    shown_ = std::move(shown);
    return arrived;
}

}  // namespace sheen
