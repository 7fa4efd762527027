#include "reference/guide.h"

#include <algorithm>
#include <bit>
#include <span>

#include "core/error.h"
#include "reference/sobol.h"

namespace sheen {
namespace {

// Less gains little where the guide is right and costs much where it missed a light.
constexpr float kUniformShare = 0.3f;

// Mean over each cell's 3 x 3 neighbourhood: one sample says little of its cell's edges.
std::vector<float> blur(int size, const std::vector<float>& cells) {
    std::vector<float> result(cells.size());
    for (int y = 0; y < size; ++y) {
        for (int x = 0; x < size; ++x) {
            float sum = 0.0f;
            int count = 0;
            for (int ny = std::max(y - 1, 0); ny <= std::min(y + 1, size - 1); ++ny) {
                for (int nx = std::max(x - 1, 0); nx <= std::min(x + 1, size - 1); ++nx) {
                    sum += cells[static_cast<size_t>(ny * size + nx)];
                    ++count;
                }
            }
            result[static_cast<size_t>(y * size + x)] = sum / static_cast<float>(count);
        }
    }
    return result;
}

// Turns cumulative sums [0, ..., total] into [0, ..., 1].
void normalise(std::span<float> cumulative) {
    const float total = cumulative.back();
    for (float& value : cumulative) {
        value /= total;
    }
    cumulative.back() = 1.0f;
}

// Inverts a piecewise linear cumulative distribution: the coordinate, and the density there.
struct Inverted {
    size_t cell;
    float coordinate;
    float density;
};
Inverted invert(std::span<const float> cumulative, float u) {
    const size_t size = cumulative.size() - 1;
    size_t cell = 0;
    for (size_t step = size / 2; step > 0; step /= 2) {
        cell += cumulative[cell + step] <= u ? step : 0;  // no branch to predict wrongly
    }
    const float lower = cumulative[cell];
    const float mass = cumulative[cell + 1] - lower;
    // The fraction stays below 1: the point must not slip into a cell of another density.
    const float fraction = std::min((u - lower) / mass, kBelowOne);
    const auto n = static_cast<float>(size);
    return {.cell = cell,
            .coordinate = std::min((static_cast<float>(cell) + fraction) / n, kBelowOne),
            .density = mass * n};
}

}  // namespace

Guide::Guide(int size, const std::vector<float>& contributions) {
    SHEEN_CHECK(std::has_single_bit(static_cast<unsigned>(size)));
    SHEEN_CHECK_EQ(contributions.size(), static_cast<size_t>(size) * static_cast<size_t>(size));
    const std::vector<float> blurred = blur(size, contributions);
    float mean = 0.0f;
    for (const float value : blurred) {
        mean += value / static_cast<float>(blurred.size());
    }
    if (!(mean > 0.0f)) {
        return;  // nothing seen: stay uniform
    }
    size_ = size;
    const auto stride = static_cast<size_t>(size) + 1;
    columns_.assign(stride, 0.0f);
    rows_.assign(stride * static_cast<size_t>(size), 0.0f);
    for (size_t x = 0; x + 1 < stride; ++x) {
        const std::span<float> rows(&rows_[x * stride], stride);
        for (size_t y = 0; y + 1 < stride; ++y) {
            const float learned = blurred[y * static_cast<size_t>(size) + x] / mean;
            rows[y + 1] = rows[y] + kUniformShare + (1.0f - kUniformShare) * learned;
        }
        columns_[x + 1] = columns_[x] + rows.back();
        normalise(rows);
    }
    normalise(columns_);
}

GuidedPoint Guide::warp(const vec2& u) const {
    if (size_ == 0) {
        return {.u = u};
    }
    const Inverted x = invert(columns_, u.x);
    const size_t stride = static_cast<size_t>(size_) + 1;
    const Inverted y = invert({&rows_[x.cell * stride], stride}, u.y);
    return {.u = vec2(x.coordinate, y.coordinate), .weight = 1.0f / (x.density * y.density)};
}

}  // namespace sheen
