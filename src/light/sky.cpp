#include "light/sky.h"

#include <algorithm>
#include <cmath>

#include "core/directions.h"

namespace sheen {
namespace {

// Cells along an image's longer side, at the most: what is smaller and bright is a sun, and a light
// of its own.
constexpr int kMostSkyCells = 512;

// What comes from each cell, [row][column]: the mean of its texels and of those around it, since
// between texels light is interpolated, times the solid angle.
std::vector<float> lightOfCells(const Image<vec3>& texels, int width, int height) {
    std::vector<float> light(static_cast<size_t>(width) * static_cast<size_t>(height));
    for (int y = 0; y < height; ++y) {
        const int y0 = std::max(y * texels.height / height - 1, 0);
        const int y1 = std::min((y + 1) * texels.height / height + 1, texels.height);
        const float sine =
            std::sin(kPi * (static_cast<float>(y) + 0.5f) / static_cast<float>(height));
        for (int x = 0; x < width; ++x) {
            const int x0 = x * texels.width / width - 1;
            const int x1 = (x + 1) * texels.width / width + 1;
            double sum = 0.0;
            for (int j = y0; j < y1; ++j) {
                for (int i = x0; i < x1; ++i) {
                    sum += luminance(texels.at((i + texels.width) % texels.width, j));
                }
            }
            light[static_cast<size_t>(y * width + x)] =
                sine * static_cast<float>(sum / ((x1 - x0) * (y1 - y0)));
        }
    }
    return light;
}

// Where in sums, which rise from 0 to 1, a number lies: an interval, and how far through it.
std::pair<int, float> find(const float* sums, int count, float u) {
    const float* above = std::upper_bound(sums + 1, sums + count, u);
    const auto i = static_cast<int>(above - sums) - 1;
    const float width = sums[i + 1] - sums[i];
    return {i, width > 0.0f ? glm::clamp((u - sums[i]) / width, 0.0f, 1.0f) : 0.5f};
}

// Makes numbers the sums up to each, from 0 to 1; returns their sum.
float accumulate(const float* numbers, int count, float* sums) {
    double sum = 0.0;
    for (int i = 0; i < count; ++i) {
        sums[i] = static_cast<float>(sum);
        sum += numbers[i];
    }
    for (int i = 0; i < count && sum > 0.0; ++i) {
        sums[i] = static_cast<float>(sums[i] / sum);
    }
    sums[count] = 1.0f;
    return static_cast<float>(sum);
}

}  // namespace

SkySampler::SkySampler(const Environment& environment) : environment_(environment) {
    const Image<vec3>& texels = environment.texels;
    if (texels.width * texels.height <= 1) {
        return;
    }
    const int longer = std::max(texels.width, texels.height);
    const int step = (longer + kMostSkyCells - 1) / kMostSkyCells;
    width_ = std::max(texels.width / step, 1);
    height_ = std::max(texels.height / step, 1);
    const std::vector<float> light = lightOfCells(texels, width_, height_);
    const auto columns = static_cast<size_t>(width_);
    cells_.resize(static_cast<size_t>(height_) * (columns + 1));
    rows_.resize(static_cast<size_t>(height_) + 1);
    std::vector<float> sums(static_cast<size_t>(height_));
    for (size_t y = 0; y < sums.size(); ++y) {
        sums[y] = accumulate(&light[y * columns], width_, &cells_[y * (columns + 1)]);
    }
    accumulate(sums.data(), height_, rows_.data());
}

SkySampler::Sample SkySampler::sample(const vec3& n, const vec2& u) const {
    if (cells_.empty()) {
        const vec3 local = cosineDirection(u);
        const vec3 wi = tangentFrame(n) * local;
        return {.wi = wi, .radiance = radiance(wi), .density = local.z / kPi};
    }
    const auto [y, within_y] = find(rows_.data(), height_, u.y);
    const float* row = &cells_[static_cast<size_t>(y) * static_cast<size_t>(width_ + 1)];
    const auto [x, within_x] = find(row, width_, u.x);
    const float share =
        (rows_[static_cast<size_t>(y) + 1] - rows_[static_cast<size_t>(y)]) * (row[x + 1] - row[x]);
    const vec2 uv = (vec2(x, y) + vec2(within_x, within_y)) / vec2(width_, height_);
    const vec3 wi = environment_.directionFromImage(uv);
    // The image spans 2 pi by pi.
    const float sine = std::max(std::sin(kPi * uv.y), 1e-6f);
    const auto cells = static_cast<float>(width_ * height_);
    return {
        .wi = wi, .radiance = radiance(wi), .density = share * cells / (2.0f * kPi * kPi * sine)};
}

}  // namespace sheen
