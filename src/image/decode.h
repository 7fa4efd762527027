// Images that others encoded: PNG, JPEG and WebP files in memory, such as a scene's textures.
// Header and pixels are read apart, so that memory can be asked for in between.
#pragma once

#include <cstdint>
#include <span>
#include <stdexcept>
#include <vector>

namespace sheen {

enum class ImageFormat { kPng, kJpeg, kWebp };

/// What a file's header promises; at least one pixel.
struct ImageHeader {
    ImageFormat format = ImageFormat::kPng;
    int width = 0;
    int height = 0;
};

/// Pixels as stored, without any transfer function: red, green, blue and alpha from 0 to 65535, row
/// by row from the top left, [pixel][4]. Grey is repeated, palettes are looked up, colour profiles
/// are left out, as glTF asks.
struct DecodedImage {
    int width = 0;
    int height = 0;
    std::vector<uint16_t> rgba;
};

/// Why a file is no image that can be read, such as "it is neither PNG, JPEG nor WebP".
class DecodeError : public std::runtime_error {
    using std::runtime_error::runtime_error;
};

/// Reads no pixels and takes memory for none. Throws DecodeError.
ImageHeader readImageHeader(std::span<const uint8_t> file);

/// Takes up to 16 bytes a pixel, of which it returns 8. Throws DecodeError where a file is damaged.
DecodedImage decodeImage(std::span<const uint8_t> file);

}  // namespace sheen
