#include "image/png.h"

#include <png.h>

#include <algorithm>
#include <cmath>
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

// `pixels` as `format` says, row by row.
std::string encode(int width, int height, png_uint_32 format, const void* pixels,
                   const std::vector<Rgb8>& colors) {
    png_image png{};
    png.version = PNG_IMAGE_VERSION;
    png.width = static_cast<png_uint_32>(width);
    png.height = static_cast<png_uint_32>(height);
    png.format = format;
    png.colormap_entries = static_cast<png_uint_32>(colors.size());
    png_alloc_size_t size = PNG_IMAGE_PNG_SIZE_MAX(png);
    std::string bytes(size, '\0');
    if (png_image_write_to_memory(&png, bytes.data(), &size, 0, pixels, 0, colors.data()) == 0) {
        throwEnvironment("cannot encode a PNG image: {}", png.message);
    }
    bytes.resize(size);
    return bytes;
}

void writeBytes(const std::string& path, const std::string& bytes) {
    AtomicFile file(path);
    file.write(bytes);
    file.commit();
}

}  // namespace

std::string pngBytes(const Image<Rgb8>& image) {
    static_assert(sizeof(Rgb8) == 3, "rows are handed to libpng as they are");
    SHEEN_CHECK(!image.empty());
    const Palette palette = paletteOf(image);
    return palette.colors.empty()
               ? encode(image.width, image.height, PNG_FORMAT_RGB, image.pixels.data(), {})
               : encode(image.width, image.height, PNG_FORMAT_RGB_COLORMAP, palette.indices.data(),
                        palette.colors);
}

std::string pngBytes(const Image<Rgb8>& image, const Image<float>& alpha) {
    SHEEN_CHECK_EQ(image.pixels.size(), alpha.pixels.size());
    std::vector<uint8_t> pixels;
    pixels.reserve(4 * image.pixels.size());
    for (size_t i = 0; i < image.pixels.size(); ++i) {
        const Rgb8& c = image.pixels[i];
        const auto a = static_cast<uint8_t>(std::lround(255.0f * alpha.pixels[i]));
        pixels.insert(pixels.end(), {c.r, c.g, c.b, a});
    }
    return encode(image.width, image.height, PNG_FORMAT_RGBA, pixels.data(), {});
}

void writePng(const std::string& path, const Image<Rgb8>& image) {
    writeBytes(path, pngBytes(image));
}

void writePng(const std::string& path, const Image<vec3>& image, std::optional<float> exposure) {
    writePng(path, displayImage(image, exposure));
}

void writePng(const std::string& path, const Frame& frame, std::optional<float> exposure,
              const ToDisplay& to_display) {
    const Image<float> opaque = alpha(frame);
    Image<vec3> seen = beauty(frame);
    // PNG wants the colour of what covers a pixel, whatever its share.
    for (size_t i = 0; i < seen.pixels.size(); ++i) {
        seen.pixels[i] /= opaque.pixels[i] > 0.0f ? opaque.pixels[i] : 1.0f;
    }
    const Image<Rgb8> image = displayImage(seen, exposure, to_display);
    if (std::all_of(opaque.pixels.begin(), opaque.pixels.end(),
                    [](float a) { return a == 1.0f; })) {
        writePng(path, image);
        return;
    }
    writeBytes(path, pngBytes(image, opaque));
}

}  // namespace sheen
