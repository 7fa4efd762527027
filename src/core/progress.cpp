#include "core/progress.h"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>

#include "core/error.h"

namespace sheen {
namespace {

constexpr double kQuietSeconds = 0.5;
constexpr int kBarWidth = 30;
constexpr int kPlainStepPercent = 10;

}  // namespace

Progress::Progress(std::string label, int64_t total, bool quiet)
    : label_(std::move(label)),
      total_(std::max<int64_t>(total, 1)),
      quiet_(quiet),
      listener_(currentListener()),
      terminal_(isatty(STDERR_FILENO) != 0) {}

Progress::~Progress() {
    if (listener_ == nullptr && terminal_ && printed_percent_ >= 0) {
        say("\n");
    }
}

void Progress::advance(int64_t steps) {
    const std::lock_guard<std::mutex> lock(mutex_);
    done_ = std::min(done_ + steps, total_);
    if (listener_ != nullptr) {
        tell(static_cast<int>(100 * done_ / total_));
    } else if (!quiet_ && timer_.seconds() > kQuietSeconds) {
        print();
    }
}

void Progress::tell(int percent) {
    if (listener_->progress && percent != printed_percent_) {
        printed_percent_ = percent;
        listener_->progress(label_, static_cast<double>(done_) / static_cast<double>(total_));
    }
}

void Progress::print() {
    const int percent = static_cast<int>(100 * done_ / total_);
    const int step = terminal_ ? 1 : kPlainStepPercent;
    if (printed_percent_ >= 0 && percent / step == printed_percent_ / step) {
        return;
    }
    printed_percent_ = percent;
    const double elapsed = timer_.seconds();
    const double left = done_ > 0 ? elapsed * static_cast<double>(total_ - done_) / done_ : 0.0;
    if (terminal_) {
        const int filled = kBarWidth * percent / 100;
        say(fmt::format("\r{} [{:#<{}}{:.<{}}] {:3}% {:.0f} s left ", label_, "", filled, "",
                        kBarWidth - filled, percent, left));
    } else {
        say(fmt::format("{} {}% ({:.0f} s left)\n", label_, percent, left));
    }
    fflush(stderr);
}

}  // namespace sheen
