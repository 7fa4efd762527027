#include "scene/sun.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/constants.hpp>
#include <vector>

namespace sheen {
namespace {

// Radius of the disc a sun may fill; the sun's own is a quarter of a degree, blurred in images by
// their texels and by the camera's glare.
constexpr double kRadius = 2.0 / 180.0 * glm::pi<double>();
// Texels of less than this share of the brightest belong to the sky.
constexpr float kDimmest = 1.0f / 32.0f;
// Of the sky's light, to be worth a light of its own.
constexpr double kLeastShare = 0.2;
// Of the texels around the sun, their median is the sky behind it.
constexpr double kRing = 1.5;

float sumOf(const vec3& v) { return v.x + v.y + v.z; }

double solidAngleOf(const Image<vec3>& texels, int y) {
    const double rows = texels.height;
    return 2.0 * glm::pi<double>() / texels.width *
           (std::cos(glm::pi<double>() * y / rows) - std::cos(glm::pi<double>() * (y + 1) / rows));
}

vec3 directionOf(const Environment& sky, int x, int y) {
    const vec2 size(sky.texels.width, sky.texels.height);
    return sky.directionFromImage((vec2(x, y) + 0.5f) / size);
}

// Calls visit(x, y) for all texels within `radius` of a direction.
template <class Visit>
void forDisc(const Environment& sky, const vec3& center, double radius, const Visit& visit) {
    const int width = sky.texels.width, height = sky.texels.height;
    const auto least = static_cast<float>(std::cos(radius));
    const double theta = std::acos(std::clamp<double>(center.y, -1.0, 1.0));
    const auto row = [&](double t) {
        return std::clamp(static_cast<int>(t / glm::pi<double>() * height), 0, height - 1);
    };
    for (int y = row(theta - radius); y <= row(theta + radius); ++y) {
        for (int x = 0; x < width; ++x) {
            if (glm::dot(directionOf(sky, x, y), center) >= least) {
                visit(x, y);
            }
        }
    }
}

// The middle of what is bright about the brightest texel, which may lie at its rim.
vec3 middleOf(const Environment& sky, vec3 center, float brightest) {
    constexpr int kRounds = 4;
    for (int round = 0; round < kRounds; ++round) {
        glm::dvec3 sum(0.0);
        forDisc(sky, center, kRadius, [&](int x, int y) {
            const float value = sumOf(sky.texels.at(x, y));
            if (value > kDimmest * brightest) {
                sum += solidAngleOf(sky.texels, y) * value * glm::dvec3(directionOf(sky, x, y));
            }
        });
        center = vec3(glm::normalize(sum));
    }
    return center;
}

double medianOf(std::vector<float>& values) {
    if (values.empty()) {
        return 0.0;
    }
    const auto middle = values.begin() + static_cast<ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

// The sky around the sun, per channel: the median of a ring about its disc.
vec3 behindSun(const Environment& sky, const vec3& center) {
    std::vector<float> values[3];
    forDisc(sky, center, kRing * kRadius, [&](int x, int y) {
        if (glm::dot(directionOf(sky, x, y), center) < std::cos(kRadius)) {
            for (int c = 0; c < 3; ++c) {
                values[c].push_back(sky.texels.at(x, y)[c]);
            }
        }
    });
    return {medianOf(values[0]), medianOf(values[1]), medianOf(values[2])};
}

}  // namespace

std::optional<shared::PunctualLight> takeOutSun(Environment& sky) {
    Image<vec3>& texels = sky.texels;
    double total = 0.0;
    float brightest = 0.0f;
    int at = 0;
    for (int i = 0; i < texels.count(); ++i) {
        const float value = sumOf(texels.pixels[static_cast<size_t>(i)]);
        total += value * solidAngleOf(texels, i / texels.width);
        if (value > brightest) {
            brightest = value;
            at = i;
        }
    }
    // An image whose texels are as large as the disc cannot show a sun.
    if (texels.height * kRadius < 2.0 * glm::pi<double>() || brightest == 0.0f) {
        return std::nullopt;
    }
    const vec3 center =
        middleOf(sky, directionOf(sky, at % texels.width, at / texels.width), brightest);
    const vec3 behind = behindSun(sky, center);
    std::vector<ivec2> disc;
    glm::dvec3 illuminance(0.0), toward(0.0);
    forDisc(sky, center, kRadius, [&](int x, int y) {
        const vec3 excess = glm::max(texels.at(x, y) - behind, vec3(0.0f));
        if (sumOf(excess) > kDimmest * brightest) {
            disc.emplace_back(x, y);
            const glm::dvec3 brings = glm::dvec3(excess) * solidAngleOf(texels, y);
            illuminance += brings;
            toward += (brings.x + brings.y + brings.z) * glm::dvec3(directionOf(sky, x, y));
        }
    });
    if (illuminance.x + illuminance.y + illuminance.z < kLeastShare * total) {
        return std::nullopt;
    }
    for (const ivec2& texel : disc) {
        vec3& value = texels.at(texel.x, texel.y);
        value = glm::min(value, behind);
    }
    shared::PunctualLight sun{};
    sun.kind = shared::LIGHT_DIRECTIONAL;
    sun.direction = -vec3(glm::normalize(toward));
    sun.intensity = vec3(illuminance);
    sun.spot_offset = 1.0f;
    sun.cos_outer = -1.0f;
    return sun;
}

}  // namespace sheen
