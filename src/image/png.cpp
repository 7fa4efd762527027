#include "image/png.h"

#include <png.h>

#include "image/atomic_file.h"

namespace sheen {

std::string pngBytes(const Image<Rgb8>& image) {
    static_assert(sizeof(Rgb8) == 3, "rows are handed to libpng as they are");
    SHEEN_CHECK(!image.empty());
    png_image png{};
    png.version = PNG_IMAGE_VERSION;
    png.width = static_cast<png_uint_32>(image.width);
    png.height = static_cast<png_uint_32>(image.height);
    png.format = PNG_FORMAT_RGB;
    png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(png);
    std::string bytes(size, '\0');
    if (png_image_write_to_memory(&png, bytes.data(), &size, 0, image.pixels.data(), 0, nullptr) ==
        0) {
        throwEnvironment("cannot encode a PNG image: {}", png.message);
    }
    bytes.resize(size);
    return bytes;
}

void writePng(const std::string& path, const Image<Rgb8>& image) {
    AtomicFile file(path);
    file.write(pngBytes(image));
    file.commit();
}

void writePng(const std::string& path, const Image<vec3>& image, std::optional<float> exposure) {
    writePng(path, displayImage(image, exposure));
}

void writePng(const std::string& path, const Frame& frame, std::optional<float> exposure) {
    writePng(path, beauty(frame), exposure);
}

}  // namespace sheen
