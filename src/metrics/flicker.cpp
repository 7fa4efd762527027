#include "metrics/flicker.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

#include "core/error.h"
#include "image/frame.h"

namespace sheen {
namespace {

template <class T>
Image<T> copyOf(const Image<T>* image) {
    return image != nullptr ? *image : Image<T>();
}

bool sameBits(const Image<vec3>& a, const Image<vec3>& b) {
    return a.pixels.size() == b.pixels.size() &&
           std::memcmp(a.pixels.data(), b.pixels.data(), a.pixels.size() * sizeof(vec3)) == 0;
}

}  // namespace

void FlickerMeter::add(int frame, const CompareInput& input) {
    checkComparable(input);
    Kept now{.frame = frame,
             .test = input.test,
             .reference = input.reference,
             .variance = copyOf(input.reference_variance),
             .test_primitive = copyOf(input.test_primitive),
             .reference_primitive = copyOf(input.reference_primitive)};
    if (last_ && last_->frame + 1 == frame) {
        if (last_->test.width != now.test.width || last_->test.height != now.test.height) {
            throwInput("{} has {}x{} pixels, the frame before {}x{}: render all at one size",
                       input.test_name, now.test.width, now.test.height, last_->test.width,
                       last_->test.height);
        }
        addPair(*last_, now);
    }
    last_ = std::move(now);
}

void FlickerMeter::addPair(const Kept& before, const Kept& after) {
    const bool told = !before.test_primitive.empty() && !before.reference_primitive.empty() &&
                      !after.test_primitive.empty() && !after.reference_primitive.empty();
    const bool noisy = !before.variance.empty() && !after.variance.empty() &&
                       !sameBits(before.reference, after.reference);
    const int64_t samples = samples_;
    for (size_t i = 0; i < before.test.pixels.size(); ++i) {
        if (told) {
            const uint32_t seen_before = before.test_primitive.pixels[i];
            const uint32_t seen_after = after.test_primitive.pixels[i];
            if (seen_before != before.reference_primitive.pixels[i] ||
                seen_after != after.reference_primitive.pixels[i] ||
                (seen_before == kNoPrimitive && seen_after == kNoPrimitive)) {
                continue;
            }
        }
        for (int c = 0; c < 3; ++c) {
            const double b0 = before.reference.pixels[i][c], b1 = after.reference.pixels[i][c];
            const double d =
                (double{after.test.pixels[i][c]} - before.test.pixels[i][c]) - (b1 - b0);
            const double v =
                noisy ? double{before.variance.pixels[i][c]} + after.variance.pixels[i][c] : 0.0;
            ++samples_;
            reference_ += 0.5 * (b0 + b1);
            squared_ += d * d;
            variance_ += v;
            // The variance of (d + noise)^2 where noise is normal.
            spread_ += 2.0 * v * v + 4.0 * std::max(0.0, d * d - v) * v;
        }
    }
    pairs_ += samples_ > samples ? 1 : 0;
}

std::optional<Flicker> FlickerMeter::result() const {
    if (samples_ == 0) {
        return std::nullopt;
    }
    const auto n = static_cast<double>(samples_);
    const double mean = reference_ / n;
    const auto relative = [&](double change) {
        return change == 0.0 ? 0.0
               : mean > 0.0  ? change / mean
                             : std::numeric_limits<double>::infinity();
    };
    return Flicker{.value = relative(std::sqrt(std::max(0.0, squared_ - variance_) / n)),
                   .resolution = relative(std::sqrt(std::sqrt(spread_) / n)),
                   .noise_share = squared_ > 0.0 ? std::min(1.0, variance_ / squared_) : 0.0,
                   .pairs = pairs_};
}

}  // namespace sheen
