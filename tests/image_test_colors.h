// An image no two pixels of which are alike.
#pragma once

#include "image/image.h"

namespace sheen {

inline Image<vec3> colors(int width, int height, float scale) {
    Image<vec3> image(width, height);
    for (int i = 0; i < image.count(); ++i) {
        image.pixels[static_cast<size_t>(i)] =
            scale * vec3(1.0f + static_cast<float>(i), 0.3f * static_cast<float>(i), 1.0f / 3.0f);
    }
    return image;
}

}  // namespace sheen
