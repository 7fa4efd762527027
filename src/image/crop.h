// A part of an image.
#pragma once

#include "core/math.h"

namespace sheen {

/// Pixels of an image: columns and rows from `first` on, as many as `size`.
struct Crop {
    ivec2 first{0};
    ivec2 size{0};
};

}  // namespace sheen
