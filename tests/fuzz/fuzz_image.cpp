// decodeImage() on any bytes: an image of the size that its header tells, or the reason why not.
#include "fuzz/fuzz.h"
#include "image/decode.h"

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    using namespace sheen;
    constexpr int64_t kMostPixels = 1 << 16;  // larger ones only take time
    const std::span<const uint8_t> file(data, size);
    try {
        const ImageHeader header = readImageHeader(file);
        fuzz::require(header.width > 0 && header.height > 0, "an image has pixels");
        const int64_t pixels = int64_t{header.width} * header.height;
        if (pixels > kMostPixels) {
            return 0;
        }
        const DecodedImage image = decodeImage(file);
        fuzz::require(image.width == header.width && image.height == header.height,
                      "an image has the size that its header tells");
        fuzz::require(image.rgba.size() == 4 * static_cast<size_t>(pixels),
                      "an image has the pixels of its size");
    } catch (const DecodeError& error) {
        fuzz::require(*error.what() != '\0', "an error has a reason");
    }
    return 0;
}
