// PNG files without compression: the same pixels give the same bytes, whatever zlib is installed.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace sheen::scenes {

/// An RGB image, 8 bits a channel, sRGB, [y][x].
struct Picture {
    int width = 0;
    int height = 0;
    std::vector<std::array<uint8_t, 3>> pixels;
};

std::vector<uint8_t> encodePng(const Picture& picture);

}  // namespace sheen::scenes
