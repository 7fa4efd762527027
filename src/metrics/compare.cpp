#include "metrics/compare.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "image/frame.h"

namespace sheen {
namespace {

constexpr int kTileSize = 16;
constexpr double kRelativeFloor = 0.01;  // of the image's mean, in relative errors of samples
constexpr double kTileFloor = 0.05;      // in those of tiles
constexpr double kMaxNoiseShare = 0.5;
constexpr double kInfinite = std::numeric_limits<double>::infinity();

enum class PixelUse { kCompared, kExcluded, kEmpty };

PixelUse pixelUse(const CompareInput& input, int x, int y) {
    if (input.test_primitive == nullptr || input.reference_primitive == nullptr) {
        return PixelUse::kCompared;
    }
    const uint32_t a = input.test_primitive->at(x, y), b = input.reference_primitive->at(x, y);
    if (a != b) {
        return PixelUse::kExcluded;
    }
    return a == kNoPrimitive ? PixelUse::kEmpty : PixelUse::kCompared;
}

void checkFinite(const Image<vec3>& image, const std::string& what) {
    for (int y = 0; y < image.height; ++y) {
        for (int x = 0; x < image.width; ++x) {
            const vec3& p = image.at(x, y);
            if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) {
                throwInput(
                    "{}: pixel ({}, {}) is not finite ({}, {}, {}), so that there is no error to "
                    "measure: render it again",
                    what, x, y, p.x, p.y, p.z);
            }
        }
    }
}

// Sums over samples.
struct Sums {
    int64_t samples = 0;
    double reference = 0, difference = 0, squared = 0, variance = 0;

    void add(const CompareInput& input, int x, int y) {
        for (int c = 0; c < 3; ++c) {
            const double b = input.reference.at(x, y)[c];
            const double d = input.test.at(x, y)[c] - b;
            ++samples;
            reference += b;
            difference += d;
            squared += d * d;
            if (input.reference_variance != nullptr) {
                variance += input.reference_variance->at(x, y)[c];
            }
        }
    }
    void add(const Sums& other) {
        samples += other.samples;
        reference += other.reference;
        difference += other.difference;
        squared += other.squared;
        variance += other.variance;
    }
    double meanReference() const { return reference / static_cast<double>(samples); }
    double meanDifference() const { return difference / static_cast<double>(samples); }
    /// Mean squared error without the reference's own noise.
    double mse() const { return std::max(0.0, squared - variance) / static_cast<double>(samples); }
};

// A ratio that is defined over a black reference.
double ratio(double error, double reference) {
    if (error == 0.0) {
        return 0.0;
    }
    return reference > 0.0 ? error / reference : std::copysign(kInfinite, error);
}

struct Tile {
    ivec2 corner{0};
    Sums sums;
};

std::vector<Tile> sumTiles(const CompareInput& input) {
    std::vector<Tile> tiles;
    const int width = input.reference.width, height = input.reference.height;
    for (int ty = 0; ty < height; ty += kTileSize) {
        for (int tx = 0; tx < width; tx += kTileSize) {
            Tile tile{.corner = ivec2(tx, ty), .sums = {}};
            for (int y = ty; y < std::min(ty + kTileSize, height); ++y) {
                for (int x = tx; x < std::min(tx + kTileSize, width); ++x) {
                    if (pixelUse(input, x, y) == PixelUse::kCompared) {
                        tile.sums.add(input, x, y);
                    }
                }
            }
            tiles.push_back(tile);
        }
    }
    return tiles;
}

Sums sumAll(const std::vector<Tile>& tiles) {
    Sums all;
    for (const Tile& tile : tiles) {
        all.add(tile.sums);
    }
    return all;
}

// Relative to the reference's sample.
double relativeTo(const CompareInput& input, int x, int y, int channel, double mean, double error) {
    return ratio(error, input.reference.at(x, y)[channel] + kRelativeFloor * mean);
}

double relativeError(const CompareInput& input, int x, int y, int channel, double mean) {
    const double b = input.reference.at(x, y)[channel];
    return relativeTo(input, x, y, channel, mean, std::abs(input.test.at(x, y)[channel] - b));
}

// The smallest value that is not below `share` of all values; reorders them.
double quantile(std::vector<double>& values, double share) {
    const auto rank = static_cast<size_t>(std::ceil(share * static_cast<double>(values.size())));
    const auto nth = values.begin() + static_cast<std::ptrdiff_t>(std::max<size_t>(rank, 1) - 1);
    std::nth_element(values.begin(), nth, values.end());
    return *nth;
}

// The same of the absolute values of normal variables with these standard deviations: of one
// variable's, erf(q / (s sqrt 2)) lie below q, and the mean of those is to be `share`. Sorts.
double quantileOfNoise(std::vector<double>& deviations, double share) {
    // From one to the next of the sorted deviations little changes: a few thousand do.
    constexpr size_t kEnough = 4096;
    constexpr int kSteps = 40;
    constexpr double kNearlyAll = 6.0;  // deviations, within which all but 2e-9 lie
    std::sort(deviations.begin(), deviations.end());
    const size_t stride = deviations.size() / kEnough + 1;
    const auto below = [&](double q) {
        double sum = 0.0;
        size_t count = 0;
        for (size_t i = stride / 2; i < deviations.size(); i += stride) {
            const double s = deviations[i];
            sum += s > 0.0 ? std::erf(q / (s * std::sqrt(2.0))) : 1.0;
            ++count;
        }
        return sum / static_cast<double>(count);
    };
    const auto infinite = std::lower_bound(deviations.begin(), deviations.end(), kInfinite);
    double low = 0.0;
    double high = infinite == deviations.begin() ? 0.0 : kNearlyAll * *std::prev(infinite);
    if (below(low) >= share) {
        return low;
    }
    if (below(high) < share) {
        return kInfinite;
    }
    for (int step = 0; step < kSteps; ++step) {
        const double q = 0.5 * (low + high);
        (below(q) < share ? low : high) = q;
    }
    return high;
}

void findWorstTile(const std::vector<Tile>& tiles, double mean, Comparison& result) {
    for (const Tile& tile : tiles) {
        if (tile.sums.samples == 0) {
            continue;
        }
        const double error =
            ratio(std::sqrt(tile.sums.mse()), tile.sums.meanReference() + kTileFloor * mean);
        if (error > result.tile_max) {
            result.tile_max = error;
            result.worst_tile = tile.corner;
        }
    }
}

}  // namespace

void checkComparable(const CompareInput& input) {
    const int width = input.reference.width, height = input.reference.height;
    const auto check_size = [&](int w, int h, const std::string& what) {
        if (w != width || h != height) {
            throwInput("{} has {}x{} pixels, {} {}x{}: render both at one size", what, w, h,
                       input.reference_name, width, height);
        }
    };
    check_size(input.test.width, input.test.height, input.test_name);
    checkFinite(input.test, input.test_name);
    checkFinite(input.reference, input.reference_name);
    if (input.reference_variance != nullptr) {
        const Image<vec3>& variance = *input.reference_variance;
        check_size(variance.width, variance.height, input.reference_name + ", variance");
        checkFinite(variance, input.reference_name + ", variance");
    }
    for (const Image<uint32_t>* primitive : {input.test_primitive, input.reference_primitive}) {
        if (primitive != nullptr) {
            check_size(primitive->width, primitive->height, "a primitive layer");
        }
    }
}

Comparison compareImages(const CompareInput& input) {
    checkComparable(input);
    const std::vector<Tile> tiles = sumTiles(input);
    const Sums all = sumAll(tiles);

    Comparison result;
    std::vector<double> relative_errors;
    std::vector<double> relative_noise;
    relative_errors.reserve(static_cast<size_t>(all.samples));
    const double mean = all.samples > 0 ? all.meanReference() : 0.0;
    for (int y = 0; y < input.reference.height; ++y) {
        for (int x = 0; x < input.reference.width; ++x) {
            switch (pixelUse(input, x, y)) {
                case PixelUse::kExcluded:
                    ++result.excluded;
                    break;
                case PixelUse::kEmpty:
                    break;
                case PixelUse::kCompared:
                    ++result.compared;
                    for (int c = 0; c < 3; ++c) {
                        relative_errors.push_back(relativeError(input, x, y, c, mean));
                        if (input.reference_variance != nullptr) {
                            const double v = input.reference_variance->at(x, y)[c];
                            relative_noise.push_back(
                                relativeTo(input, x, y, c, mean, std::sqrt(std::max(v, 0.0))));
                        }
                    }
                    break;
            }
        }
    }
    if (all.samples == 0) {
        return result;
    }

    result.rel_rmse = ratio(std::sqrt(all.mse()), mean);
    result.rel_mse = result.rel_rmse * result.rel_rmse;
    result.bias = ratio(all.meanDifference(), mean);
    result.median = quantile(relative_errors, 0.5);
    result.p99 = quantile(relative_errors, 0.99);
    if (!relative_noise.empty()) {
        result.noise_median = quantileOfNoise(relative_noise, 0.5);
        result.noise_p99 = quantileOfNoise(relative_noise, 0.99);
    }
    result.max = *std::max_element(relative_errors.begin(), relative_errors.end());
    findWorstTile(tiles, mean, result);
    result.noise_share = all.squared > 0.0 ? std::min(1.0, all.variance / all.squared) : 0.0;
    result.judged = result.noise_share <= kMaxNoiseShare;
    return result;
}

vec3 viridis(float t) {
    constexpr vec3 kCoefficients[] = {{0.2777273272f, 0.0054073445f, 0.3340998053f},
                                      {0.1050930431f, 1.4046135299f, 1.3845901626f},
                                      {-0.3308618287f, 0.2148475595f, 0.0950951630f},
                                      {-4.6342304990f, -5.7991009734f, -19.3324409563f},
                                      {6.2282699363f, 14.1799333668f, 56.6905526007f},
                                      {4.7763849977f, -13.7451453777f, -65.3530326334f},
                                      {-5.4354558559f, 4.6458526122f, 26.3124352496f}};
    t = glm::clamp(t, 0.0f, 1.0f);
    vec3 sum(0.0f);
    for (int i = 6; i >= 0; --i) {
        sum = sum * t + kCoefficients[i];
    }
    return glm::clamp(sum, vec3(0.0f), vec3(1.0f));
}

Image<vec3> heatmap(const CompareInput& input) {
    constexpr double kLowest = 1e-3;  // of three decades
    constexpr double kSteps = 252;    // so few colours that a PNG needs a byte a pixel
    checkComparable(input);
    const Sums all = sumAll(sumTiles(input));
    const double mean = all.samples > 0 ? all.meanReference() : 0.0;
    Image<vec3> image(input.reference.width, input.reference.height);
    for (int y = 0; y < image.height; ++y) {
        for (int x = 0; x < image.width; ++x) {
            const PixelUse use = pixelUse(input, x, y);
            if (use != PixelUse::kCompared) {
                image.at(x, y) = vec3(use == PixelUse::kExcluded ? 0.5f : 0.0f);
                continue;
            }
            double error = 0.0;
            for (int c = 0; c < 3; ++c) {
                error += relativeError(input, x, y, c, mean) / 3.0;
            }
            const double t = std::log10(glm::clamp(error, kLowest, 1.0) / kLowest) / 3.0;
            image.at(x, y) = viridis(static_cast<float>(std::round(t * kSteps) / kSteps));
        }
    }
    return image;
}

}  // namespace sheen
