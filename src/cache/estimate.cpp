#include "cache/estimate.h"

#include <algorithm>
#include <cmath>
#include <optional>

#include "receivers/predicted.h"
#include "receivers/served.h"

namespace sheen {
namespace {

// A record's neighbours alone know less of the light at its place than the image does, where the
// record serves too. Measured on cornell_diffuse and venus_glossy (docs/decisions/estimate.md).
constexpr double kCalibration = 0.79;
// What the median record's error weighs beside what neighbours say of a record: as much as one of
// them does from two thirds of its reach.
constexpr double kMedianWeight = 0.5;

// Each record's squared error relative to its own light, as its neighbours tell it; none where they
// tell of no record.
std::optional<std::vector<double>> recordErrors(const Receivers& receivers,
                                                const RecordCache& cache,
                                                std::span<const int> record_pixels,
                                                const WeightParams& weight) {
    const std::vector<Record>& records = cache.records;
    constexpr int kNone = -1;
    std::vector<int> hosted(receivers.positions.size(), kNone);
    for (size_t k = 0; k < records.size(); ++k) {
        hosted[static_cast<size_t>(record_pixels[k])] = static_cast<int>(k);
    }
    const auto outgoing = [&](size_t k, size_t pixel) {
        return outgoingLuminance(receivers, records[k], cache.sh.data() + records[k].sh_first,
                                 pixel);
    };
    // Each record as the others predict it.
    std::vector<double> weights(records.size());
    std::vector<double> predicted(records.size());
    for (size_t k = 0; k < records.size(); ++k) {
        const auto hosts = [&](size_t pixel) { return hosted[pixel] != kNone; };
        forServed(receivers, records[k], weight, hosts, [&](size_t pixel, float w) {
            const int host = hosted[pixel];
            if (host != static_cast<int>(k)) {
                weights[static_cast<size_t>(host)] += w;
                predicted[static_cast<size_t>(host)] += w * outgoing(k, pixel);
            }
        });
    }
    std::vector<double> error2(records.size());
    std::vector<double> known;
    for (size_t k = 0; k < records.size(); ++k) {
        if (weights[k] <= 0.0) {
            continue;
        }
        const double own = outgoing(k, static_cast<size_t>(record_pixels[k]));
        const double other = predicted[k] / weights[k];
        const double scale = std::max(std::abs(own), std::abs(other));
        if (!std::isfinite(scale)) {
            weights[k] = 0.0;  // more light than floats hold
            continue;
        }
        error2[k] = scale > 0.0 ? (own - other) * (own - other) / (scale * scale) : 0.0;
        known.push_back(error2[k]);
    }
    if (known.empty() && !records.empty()) {
        return std::nullopt;
    }
    // Neighbours at the end of their reach, on the other side of an edge, predict what the image
    // never shows; records that no other reaches, rims a pixel wide, are right where they lie.
    // The less is known of a record, the more it errs as the median one.
    if (!known.empty()) {
        const auto middle = known.begin() + static_cast<std::ptrdiff_t>(known.size() / 2);
        std::nth_element(known.begin(), middle, known.end());
        for (size_t k = 0; k < records.size(); ++k) {
            error2[k] =
                (weights[k] * error2[k] + kMedianWeight * *middle) / (weights[k] + kMedianWeight);
        }
    }
    return error2;
}

}  // namespace

NeighbourErrors neighbourErrors(const Receivers& receivers, const RecordCache& cache,
                                std::span<const int> record_pixels, const WeightParams& weight,
                                const Image<vec3>& indirect) {
    const PixelGrid& image = receivers.image;
    NeighbourErrors errors{.squares = Image<float>(image.width, image.height)};
    const auto error2 = recordErrors(receivers, cache, record_pixels, weight);
    if (!error2) {
        errors.rel_rmse = kInfinity;
        return errors;
    }
    const std::vector<Record>& records = cache.records;
    const auto counts = [&](size_t pixel) { return isJudged(pixel, image.width); };
    std::vector<double> sums(receivers.positions.size());
    std::vector<double> variances(receivers.positions.size());
    for (size_t k = 0; k < records.size(); ++k) {
        forServed(receivers, records[k], weight, counts, [&](size_t pixel, float w) {
            sums[pixel] += w;
            variances[pixel] += static_cast<double>(w) * w * (*error2)[k];
        });
    }
    double squares = 0.0;
    double mean = 0.0;
    double count = 0.0;
    for (int y = 0; y < indirect.height; y += 2) {
        for (int x = 0; x < indirect.width; x += 2) {
            const size_t pixel = image.index(x, y);
            if (!receivers.seen(pixel)) {
                continue;
            }
            const double light = luminance(indirect.pixels[pixel]);
            const double sum = sums[pixel];
            mean += light;
            count += 1.0;
            if (sum > 0.0) {
                const double square =
                    kCalibration * kCalibration * variances[pixel] / (sum * sum) * light * light;
                squares += square;
                errors.squares.pixels[pixel] = static_cast<float>(square);
            }
        }
    }
    errors.rel_rmse = mean > 0.0 ? std::sqrt(squares * count) / mean : 0.0;
    return errors;
}

}  // namespace sheen
