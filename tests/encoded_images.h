// JPEG files for tests of what decodes them.
#pragma once

#include <turbojpeg.h>

#include <cstdint>
#include <stdexcept>
#include <vector>

namespace sheen {

/// A JPEG file of `width` columns from `pixels`, [pixel][components]: 1 grey, 3 RGB, 4 CMYK as
/// light let through. `flags`: of libjpeg-turbo.
inline std::vector<uint8_t> encodeJpeg(const std::vector<uint8_t>& pixels, int width,
                                       int components, int flags = 0) {
    const int height = static_cast<int>(pixels.size()) / (components * width);
    const int format = components == 1 ? TJPF_GRAY : components == 3 ? TJPF_RGB : TJPF_CMYK;
    constexpr int kBest = 100;
    unsigned char* bytes = nullptr;
    unsigned long size = 0;
    const tjhandle handle = tjInitCompress();
    const int failed = tjCompress2(handle, pixels.data(), width, 0, height, format, &bytes, &size,
                                   components == 1 ? TJSAMP_GRAY : TJSAMP_444, kBest, flags);
    std::vector<uint8_t> file(bytes, bytes + (failed != 0 ? 0 : size));
    tjFree(bytes);
    tjDestroy(handle);
    if (failed != 0) {
        throw std::runtime_error("cannot encode a JPEG");
    }
    return file;
}

}  // namespace sheen
