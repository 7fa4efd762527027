#include "image/png.h"

#include <png.h>

#include <map>
#include <vector>

#include "image/atomic_file.h"

namespace sheen {
namespace {

struct Palette {
    std::vector<Rgb8> colors;      ///< in the order they first appear
    std::vector<uint8_t> indices;  ///< [pixel]
};

// The image's colours where they are few enough for a byte a pixel; none otherwise.
Palette paletteOf(const Image<Rgb8>& image) {
    constexpr size_t kMostColors = 256;
    Palette palette;
    std::map<uint32_t, uint8_t> index_of;
    for (const Rgb8& c : image.pixels) {
        const uint32_t key =
            static_cast<uint32_t>(c.r) << 16 | static_cast<uint32_t>(c.g) << 8 | c.b;
        const auto found = index_of.find(key);
        if (found != index_of.end()) {
            palette.indices.push_back(found->second);
            continue;
        }
        if (palette.colors.size() == kMostColors) {
            return {};
        }
        const auto index = static_cast<uint8_t>(palette.colors.size());
        index_of.emplace(key, index);
        palette.colors.push_back(c);
        palette.indices.push_back(index);
    }
    return palette;
}

}  // namespace

std::string pngBytes(const Image<Rgb8>& image) {
    static_assert(sizeof(Rgb8) == 3, "rows are handed to libpng as they are");
    SHEEN_CHECK(!image.empty());
    png_image png{};
    png.version = PNG_IMAGE_VERSION;
    png.width = static_cast<png_uint_32>(image.width);
    png.height = static_cast<png_uint_32>(image.height);
    png.format = PNG_FORMAT_RGB;
    const void* pixels = image.pixels.data();
    const Palette palette = paletteOf(image);
    if (!palette.colors.empty()) {
        png.format = PNG_FORMAT_RGB_COLORMAP;
        png.colormap_entries = static_cast<png_uint_32>(palette.colors.size());
        pixels = palette.indices.data();
    }
    png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(png);
    std::string bytes(size, '\0');
    if (png_image_write_to_memory(&png, bytes.data(), &size, 0, pixels, 0, palette.colors.data()) ==
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
