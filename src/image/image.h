// A rectangle of values, row by row from the top left.
#pragma once

#include <cstddef>
#include <vector>

#include "core/error.h"
#include "core/math.h"

namespace sheen {

/// Empty (0 x 0) until given a size; pixels are value-initialised.
template <class T>
struct Image {
    int width = 0;
    int height = 0;
    std::vector<T> pixels;

    Image() = default;
    Image(int w, int h, const T& value = T{})
        : width(w), height(h), pixels(static_cast<size_t>(w) * static_cast<size_t>(h), value) {
        SHEEN_CHECK(w >= 0 && h >= 0);
    }
    bool empty() const { return pixels.empty(); }
    int count() const { return width * height; }
    T& at(int x, int y) { return pixels[static_cast<size_t>(y) * width + x]; }
    const T& at(int x, int y) const { return pixels[static_cast<size_t>(y) * width + x]; }
};

}  // namespace sheen
