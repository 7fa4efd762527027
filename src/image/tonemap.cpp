#include "image/tonemap.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace sheen {
namespace {

constexpr float kMiddleGrey = 0.18f;
// Of the mean luminance. What lies in the dark of an object alone in space is lit by a thousandth
// of the rest: counted as it is, it would burn out all else.
constexpr double kDarkestShare = 1.0 / 16.0;
// Beyond this exponent 2^EV leaves float's range.
constexpr float kMaxStops = 126.0f;
constexpr float kSurelyWhite = 1e30f;
constexpr Rgb8 kNotFinite = {255, 0, 255};

uint8_t byteFromUnit(float unit) {
    return static_cast<uint8_t>(std::lround(255.0f * std::clamp(unit, 0.0f, 1.0f)));
}

Rgb8 bytesFromUnit(const vec3& unit) {
    return {byteFromUnit(unit.r), byteFromUnit(unit.g), byteFromUnit(unit.b)};
}

}  // namespace

float autoExposure(const Image<vec3>& image) {
    std::vector<float> luminances;
    double sum = 0.0;
    for (const vec3& pixel : image.pixels) {
        const float y = luminance(pixel);
        if (std::isfinite(y) && y > 0.0f) {
            luminances.push_back(y);
            sum += y;
        }
    }
    if (luminances.empty()) {
        return 0.0f;
    }
    // The paper's delta, which keeps dark pixels from deciding, relative to the image.
    const double count = static_cast<double>(luminances.size());
    const double floor = kDarkestShare * sum / count;
    double sum_log2 = 0.0;
    for (const float luminance : luminances) {
        sum_log2 += std::log2(std::max<double>(luminance, floor));
    }
    return static_cast<float>(std::log2(kMiddleGrey) - sum_log2 / count);
}

vec3 toneMap(const vec3& color, ToneCurve curve) {
    if (curve == ToneCurve::kNone) {
        return glm::clamp(color, 0.0f, 1.0f);
    }
    // The symbols of [KhronosNeutral]; d = 1 - K_s.
    constexpr float kF90 = 0.04f;
    constexpr float kKs = 0.8f - kF90;
    constexpr float kKd = 0.15f;
    constexpr float kD = 1.0f - kKs;

    const vec3 c = glm::max(color, vec3(0.0f));
    const float x = std::min({c.r, c.g, c.b});
    const float f = x <= 2.0f * kF90 ? x - x * x / (4.0f * kF90) : kF90;
    const vec3 toed = c - f;
    const float p = std::max({toed.r, toed.g, toed.b});
    if (p <= kKs) {
        return toed;
    }
    const float p_n = 1.0f - kD * kD / (p + kD - kKs);
    const float g = 1.0f / (kKd * (p - p_n) + 1.0f);
    return glm::min(toed * (p_n / p * g) + p_n * (1.0f - g), vec3(1.0f));
}

float srgbFromLinear(float linear) {
    return linear <= 0.0031308f ? 12.92f * linear : 1.055f * std::pow(linear, 1.0f / 2.4f) - 0.055f;
}

Image<Rgb8> bytesFromDisplay(const Image<vec3>& image) {
    Image<Rgb8> bytes(image.width, image.height);
    std::transform(image.pixels.begin(), image.pixels.end(), bytes.pixels.begin(), bytesFromUnit);
    return bytes;
}

ToDisplay toSrgb(ToneCurve curve) {
    return [curve](const vec3& color) {
        const vec3 mapped = toneMap(color, curve);
        return vec3(srgbFromLinear(mapped.r), srgbFromLinear(mapped.g), srgbFromLinear(mapped.b));
    };
}

Image<Rgb8> displayImage(const Image<vec3>& image, std::optional<float> exposure,
                         const ToDisplay& to_display) {
    const float stops = exposure ? *exposure : autoExposure(image);
    const float scale = std::exp2(std::clamp(stops, -kMaxStops, kMaxStops));
    Image<Rgb8> display(image.width, image.height);
    for (size_t i = 0; i < image.pixels.size(); ++i) {
        if (!finite(image.pixels[i])) {
            display.pixels[i] = kNotFinite;
            continue;
        }
        // Exposing may overflow where the pixel itself is finite; curves are flat far below.
        display.pixels[i] =
            bytesFromUnit(to_display(glm::min(image.pixels[i] * scale, vec3(kSurelyWhite))));
    }
    return display;
}

}  // namespace sheen
