// Textures: images with smaller copies of themselves, and how they are looked up.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/math.h"
#include "scene/shared.h"

namespace sheen {

/// An image as the file stores it, without any transfer function: [y][x][4], first row first, red,
/// green, blue and alpha.
struct TextureImage {
    int width = 0;
    int height = 0;
    // One of the two is empty.
    std::vector<uint8_t> bytes = {};   ///< of 255
    std::vector<uint16_t> words = {};  ///< of 65535
    /// [srgb]: the image at half its size, at a quarter and so on down to one texel, each the mean
    /// of what it shows in linear light; empty where no texture takes its colours so.
    std::array<std::vector<TextureImage>, 2> smaller = {};

    size_t texelCount() const { return static_cast<size_t>(width) * static_cast<size_t>(height); }
    /// Level 0 is the image itself.
    int levels(bool srgb) const { return 1 + static_cast<int>(smaller[srgb ? 1 : 0].size()); }
    const TextureImage& level(bool srgb, int level) const {
        return level == 0 ? *this : smaller[srgb ? 1 : 0][static_cast<size_t>(level) - 1];
    }
};

/// A way to look an image up.
struct Texture {
    int image = 0;  ///< index into Scene::images
    glm::ivec2 wrap{shared::WRAP_REPEAT};
    bool nearest = false;  ///< not interpolated where it is magnified
    bool srgb = false;     ///< colours are sRGB, not linear light; alpha never is

    bool operator==(const Texture&) const = default;
};

/// A texel in linear light, with alpha.
vec4 texelOf(const TextureImage& image, bool srgb, int x, int y);

/// All texels, [y][x], in linear light.
std::vector<vec4> linearTexels(const TextureImage& image, bool srgb);

/// The image at half its size, each texel the mean, in linear light, of what it covers; of one
/// texel along a side where there is one.
TextureImage halved(const TextureImage& image, bool srgb);

/// Fills `smaller` for textures of that kind, once.
void makeSmaller(TextureImage& image, bool srgb);

/// A texture at (u, v), bilinear within levels and linear between them (shared::textureLevel()); at
/// level 0 or below, the nearest texel where the texture asks for it.
vec4 sampled(const TextureImage& image, const Texture& texture, const vec2& uv, float level);

}  // namespace sheen
