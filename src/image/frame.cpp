#include "image/frame.h"

namespace sheen {

Image<float> alpha(const Frame& frame) {
    Image<float> image(frame.width(), frame.height(), 1.0f);
    for (size_t i = 0; i < image.pixels.size() && !frame.shows_sky; ++i) {
        const bool seen = frame.primitive.pixels[i] != kNoPrimitive;
        image.pixels[i] = !frame.coverage.empty() ? frame.coverage.pixels[i] : seen ? 1.0f : 0.0f;
    }
    return image;
}

Image<vec3> beauty(const Frame& frame) {
    Image<vec3> sum(frame.width(), frame.height());
    for (const Image<vec3>* layer :
         {&frame.direct, &frame.indirect, &frame.caustic, &frame.emission}) {
        if (layer->empty()) {
            continue;
        }
        SHEEN_CHECK_EQ(layer->pixels.size(), sum.pixels.size());
        for (size_t i = 0; i < sum.pixels.size(); ++i) {
            sum.pixels[i] += layer->pixels[i];
        }
    }
    return sum;
}

}  // namespace sheen
