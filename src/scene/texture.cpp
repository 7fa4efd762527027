// Based on: [Wil83] for smaller copies of images.
#include "scene/texture.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/parallel.h"

namespace sheen {
namespace {

float linearFromSrgb(float s) {
    return s <= 0.04045f ? s / 12.92f : std::pow((s + 0.055f) / 1.055f, 2.4f);
}

float srgbFromLinear(float l) {
    return l <= 0.0031308f ? 12.92f * l : 1.055f * std::pow(l, 1.0f / 2.4f) - 0.055f;
}

// Linear light, by what is stored.
std::vector<float> transferTable(size_t size, bool srgb) {
    std::vector<float> table(size);
    for (size_t i = 0; i < size; ++i) {
        const float stored = static_cast<float>(i) / static_cast<float>(size - 1);
        table[i] = srgb ? linearFromSrgb(stored) : stored;
    }
    return table;
}

// Which of n texels the texel i of half as many covers, and by how much each: two, or of an odd
// number up to three, of which it shares the outer ones with its neighbours.
struct Covered {
    int first = 0;
    int count = 0;
    float weights[3] = {};
};
Covered coveredBy(int i, int half, int n) {
    const double step = static_cast<double>(n) / half;
    const double from = i * step;
    const double to = from + step;
    Covered covered{.first = static_cast<int>(from)};
    for (int k = covered.first; k < n && k < to && covered.count < 3; ++k) {
        const double overlap = std::min(to, k + 1.0) - std::max(from, static_cast<double>(k));
        covered.weights[covered.count++] = static_cast<float>(overlap / step);
    }
    return covered;
}

// Writes a texel as images store it.
template <class T>
void store(const vec4& linear, bool srgb, T* texel) {
    constexpr auto kMost = static_cast<float>(std::numeric_limits<T>::max());
    for (int c = 0; c < 4; ++c) {
        const float value = srgb && c < 3 ? srgbFromLinear(linear[c]) : linear[c];
        texel[c] = static_cast<T>(std::clamp(value, 0.0f, 1.0f) * kMost + 0.5f);
    }
}

vec4 bilinear(const TextureImage& image, const Texture& texture, const vec2& uv) {
    const shared::TextureTaps taps =
        shared::textureTaps(uv, {image.width, image.height}, texture.wrap);
    const auto texel = [&](int x, int y) { return texelOf(image, texture.srgb, x, y); };
    const vec4 lower = glm::mix(texel(taps.lower.x, taps.lower.y),
                                texel(taps.upper.x, taps.lower.y), taps.fraction.x);
    const vec4 upper = glm::mix(texel(taps.lower.x, taps.upper.y),
                                texel(taps.upper.x, taps.upper.y), taps.fraction.x);
    return glm::mix(lower, upper, taps.fraction.y);
}

}  // namespace

vec4 texelOf(const TextureImage& image, bool srgb, int x, int y) {
    static const std::vector<float> of_bytes[] = {transferTable(256, false),
                                                  transferTable(256, true)};
    const size_t first = 4 * (static_cast<size_t>(y) * image.width + x);
    if (!image.bytes.empty()) {
        const uint8_t* stored = image.bytes.data() + first;
        const std::vector<float>& color = of_bytes[srgb ? 1 : 0];
        return {color[stored[0]], color[stored[1]], color[stored[2]], of_bytes[0][stored[3]]};
    }
    static const std::vector<float> of_words[] = {transferTable(65536, false),
                                                  transferTable(65536, true)};
    const uint16_t* stored = image.words.data() + first;
    const std::vector<float>& color = of_words[srgb ? 1 : 0];
    return {color[stored[0]], color[stored[1]], color[stored[2]], of_words[0][stored[3]]};
}

std::vector<vec4> linearTexels(const TextureImage& image, bool srgb) {
    std::vector<vec4> texels;
    texels.reserve(image.texelCount());
    for (int y = 0; y < image.height; ++y) {
        for (int x = 0; x < image.width; ++x) {
            texels.push_back(texelOf(image, srgb, x, y));
        }
    }
    return texels;
}

TextureImage halved(const TextureImage& image, bool srgb) {
    TextureImage half{.width = std::max(image.width / 2, 1),
                      .height = std::max(image.height / 2, 1)};
    half.bytes.resize(image.bytes.empty() ? 0 : 4 * half.texelCount());
    half.words.resize(image.words.empty() ? 0 : 4 * half.texelCount());
    constexpr int kGrain = 16;
    parallelFor(
        half.height,
        [&](int y) {
            const Covered rows = coveredBy(y, half.height, image.height);
            for (int x = 0; x < half.width; ++x) {
                const Covered columns = coveredBy(x, half.width, image.width);
                vec4 mean(0.0f);
                for (int j = 0; j < rows.count; ++j) {
                    for (int i = 0; i < columns.count; ++i) {
                        mean += rows.weights[j] * columns.weights[i] *
                                texelOf(image, srgb, columns.first + i, rows.first + j);
                    }
                }
                const size_t first = 4 * (static_cast<size_t>(y) * half.width + x);
                if (image.words.empty()) {
                    store(mean, srgb, &half.bytes[first]);
                } else {
                    store(mean, srgb, &half.words[first]);
                }
            }
        },
        kGrain);
    return half;
}

void makeSmaller(TextureImage& image, bool srgb) {
    std::vector<TextureImage>& smaller = image.smaller[srgb ? 1 : 0];
    if (!smaller.empty()) {
        return;
    }
    for (const TextureImage* last = &image; last->texelCount() > 1; last = &smaller.back()) {
        smaller.push_back(halved(*last, srgb));
    }
}

vec4 sampled(const TextureImage& image, const Texture& texture, const vec2& uv, float level) {
    const int last = image.levels(texture.srgb) - 1;
    if (!(level > 0.0f) || last == 0) {
        if (texture.nearest) {
            const ivec2 at =
                shared::nearestTaps(uv, {image.width, image.height}, texture.wrap).lower;
            return texelOf(image, texture.srgb, at.x, at.y);
        }
        return bilinear(image, texture, uv);
    }
    const float clamped = std::min(level, static_cast<float>(last));
    const int finer = std::min(static_cast<int>(clamped), std::max(last - 1, 0));
    const vec4 fine = bilinear(image.level(texture.srgb, finer), texture, uv);
    const vec4 coarse = bilinear(image.level(texture.srgb, std::min(finer + 1, last)), texture, uv);
    return glm::mix(fine, coarse, clamped - static_cast<float>(finer));
}

}  // namespace sheen
