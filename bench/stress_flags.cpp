#include "stress_flags.h"

#include <algorithm>
#include <cmath>

#include "metrics/compare.h"

namespace sheen {
namespace {

constexpr int kTile = 8;

bool finite(const vec3& v) { return std::isfinite(v.x + v.y + v.z); }

float luminance(const vec3& c) { return 0.2126f * c.x + 0.7152f * c.y + 0.0722f * c.z; }

void heed(Worst& worst, double excess, int x, int y) {
    if (excess > worst.excess) {
        worst = {excess, ivec2(x, y)};
    }
}

// Error over its bound; a bound of zero tolerates no error. At most a number that can be printed.
double excessOf(double error, double bound) {
    constexpr double kMost = 999.0;
    return error > bound * kMost ? kMost : (error > 0.0 ? error / bound : 0.0);
}

class Judge {
  public:
    Judge(const Frame& test, const Frame& reference, const FlagBounds& bounds)
        : test_(test), reference_(reference), bounds_(bounds) {}
    Flags judge();

  private:
    bool judged(int x, int y) const {
        const uint32_t triangle = reference_.primitive.at(x, y);
        return triangle != kNoPrimitive && triangle == test_.primitive.at(x, y);
    }
    double meanOf(const Image<vec3>& layer) const;
    void poolVariance();
    double otherLight(int x, int y, int c) const {
        return reference_.direct.at(x, y)[c] + reference_.emission.at(x, y)[c];
    }
    void judgePixels();
    void countPatches();
    void judgeTiles();
    void judgeDirect();
    void compareAll();

    const Frame& test_;
    const Frame& reference_;
    const FlagBounds& bounds_;
    double mean_ = 0;
    Image<vec3> variance_;
    Flags flags_;
};

// Mean luminance over pixels with geometry, highlights cut.
double Judge::meanOf(const Image<vec3>& layer) const {
    std::vector<double> values;
    for (size_t i = 0; i < layer.pixels.size(); ++i) {
        if (reference_.primitive.pixels[i] != kNoPrimitive && finite(layer.pixels[i])) {
            values.push_back(luminance(layer.pixels[i]));
        }
    }
    if (values.empty()) {
        return 0.0;
    }
    const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    const double cut = bounds_.highlight * *middle;
    double sum = 0.0;
    for (double v : values) {
        sum += cut > 0.0 ? std::min(v, cut) : v;
    }
    return sum / static_cast<double>(values.size());
}

void Judge::poolVariance() {
    constexpr int kRadius = 2;
    variance_ = reference_.indirect_variance;
    for (int y = 0; y < variance_.height; ++y) {
        for (int x = 0; x < variance_.width; ++x) {
            vec3 sum(0.0f);
            float count = 0.0f;
            for (int v = std::max(y - kRadius, 0); v <= std::min(y + kRadius, variance_.height - 1);
                 ++v) {
                for (int u = std::max(x - kRadius, 0);
                     u <= std::min(x + kRadius, variance_.width - 1); ++u) {
                    sum += reference_.indirect_variance.at(u, v);
                    count += 1.0f;
                }
            }
            variance_.at(x, y) = glm::max(variance_.at(x, y), sum / count);
        }
    }
}

void Judge::judgePixels() {
    for (int y = 0; y < reference_.height(); ++y) {
        for (int x = 0; x < reference_.width(); ++x) {
            const vec3& a = test_.indirect.at(x, y);
            const vec3& b = reference_.indirect.at(x, y);
            flags_.geometry += reference_.primitive.at(x, y) != kNoPrimitive ? 1 : 0;
            flags_.nonfinite += finite(a) && finite(b) && finite(test_.direct.at(x, y)) ? 0 : 1;
            if (!judged(x, y)) {
                const bool other = reference_.primitive.at(x, y) != test_.primitive.at(x, y);
                flags_.other_triangle += other ? 1 : 0;
                flags_.mask.at(x, y) |= other ? 8 : 0;
                continue;
            }
            double excess = 0.0;
            for (int c = 0; c < 3; ++c) {
                const double sigma = std::sqrt(variance_.at(x, y)[c]);
                const double bound = bounds_.pixel_share * b[c] + bounds_.pixel_floor * mean_ +
                                     bounds_.unseen * otherLight(x, y, c) + bounds_.sigmas * sigma;
                excess = std::max(excess, excessOf(std::abs(a[c] - b[c]), bound));
            }
            heed(flags_.pixel, excess, x, y);
            if (excess > 1.0) {
                ++flags_.pixels;
                flags_.mask.at(x, y) |= 1;
            }
        }
    }
}

void Judge::countPatches() {
    constexpr int kNeighbours = 3;
    const Image<uint8_t>& mask = flags_.mask;
    for (int y = 0; y < mask.height; ++y) {
        for (int x = 0; x < mask.width; ++x) {
            int flagged = 0;  // itself included
            for (int v = std::max(y - 1, 0); v <= std::min(y + 1, mask.height - 1); ++v) {
                for (int u = std::max(x - 1, 0); u <= std::min(x + 1, mask.width - 1); ++u) {
                    flagged += mask.at(u, v) & 1;
                }
            }
            flags_.patches += (mask.at(x, y) & 1) != 0 && flagged > kNeighbours ? 1 : 0;
        }
    }
}

void Judge::judgeTiles() {
    for (int ty = 0; ty + kTile <= reference_.height(); ty += kTile) {
        for (int tx = 0; tx + kTile <= reference_.width(); tx += kTile) {
            glm::dvec3 difference(0.0), level(0.0), variance(0.0), other(0.0);
            int count = 0;
            for (int y = ty; y < ty + kTile; ++y) {
                for (int x = tx; x < tx + kTile; ++x) {
                    if (judged(x, y)) {
                        ++count;
                        difference += glm::dvec3(test_.indirect.at(x, y)) -
                                      glm::dvec3(reference_.indirect.at(x, y));
                        level += glm::dvec3(reference_.indirect.at(x, y));
                        variance += glm::dvec3(reference_.indirect_variance.at(x, y));
                        other += glm::dvec3(reference_.direct.at(x, y)) +
                                 glm::dvec3(reference_.emission.at(x, y));
                    }
                }
            }
            if (count < kTile * kTile / 4) {
                continue;  // too few to be more than single pixels
            }
            double excess = 0.0;
            for (int c = 0; c < 3; ++c) {
                const double n = count;
                const double bound = bounds_.tile_share * level[c] / n +
                                     bounds_.tile_floor * mean_ + bounds_.unseen * other[c] / n +
                                     bounds_.sigmas * std::sqrt(variance[c]) / n;
                excess = std::max(excess, excessOf(std::abs(difference[c]) / n, bound));
            }
            heed(flags_.tile, excess, tx, ty);
            if (excess > 1.0) {
                ++flags_.tiles;
                for (int k = 0; k < kTile * kTile; ++k) {
                    flags_.mask.at(tx + k % kTile, ty + k / kTile) |= 4;
                }
            }
        }
    }
}

void Judge::judgeDirect() {
    const double mean = meanOf(reference_.direct);
    const int r = bounds_.direct_radius;
    for (int y = 0; y < reference_.height(); ++y) {
        for (int x = 0; x < reference_.width(); ++x) {
            if (!judged(x, y)) {
                continue;
            }
            vec3 low(kInfinity), high(0.0f);
            for (int v = std::max(y - r, 0); v <= std::min(y + r, reference_.height() - 1); ++v) {
                for (int u = std::max(x - r, 0); u <= std::min(x + r, reference_.width() - 1);
                     ++u) {
                    low = glm::min(low, reference_.direct.at(u, v));
                    high = glm::max(high, reference_.direct.at(u, v));
                }
            }
            const vec3& a = test_.direct.at(x, y);
            double excess = 0.0;
            for (int c = 0; c < 3; ++c) {
                const double outside = std::max({low[c] - a[c], a[c] - high[c], 0.0f});
                const double bound = bounds_.direct_share * high[c] + bounds_.direct_floor * mean;
                excess = std::max(excess, excessOf(outside, bound));
            }
            heed(flags_.direct_pixel, excess, x, y);
            if (excess > 1.0) {
                ++flags_.direct;
                flags_.mask.at(x, y) |= 2;
            }
        }
    }
}

void Judge::compareAll() {
    const Comparison c = compareImages({.test = test_.indirect,
                                        .reference = reference_.indirect,
                                        .reference_variance = &reference_.indirect_variance,
                                        .test_primitive = &test_.primitive,
                                        .reference_primitive = &reference_.primitive});
    flags_.rel_rmse = c.rel_rmse;
    flags_.bias = c.bias;
    flags_.noise_share = c.noise_share;
    flags_.known = c.judged;
}

Flags Judge::judge() {
    flags_.mask = Image<uint8_t>(reference_.width(), reference_.height());
    mean_ = meanOf(reference_.indirect);
    poolVariance();
    judgePixels();
    countPatches();
    judgeTiles();
    judgeDirect();
    if (flags_.nonfinite == 0) {
        compareAll();
    }
    return std::move(flags_);
}

}  // namespace

Flags flagErrors(const Frame& test, const Frame& reference, const FlagBounds& bounds) {
    return Judge(test, reference, bounds).judge();
}

}  // namespace sheen
