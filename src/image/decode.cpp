#include "image/decode.h"

#include <png.h>
#include <turbojpeg.h>
#include <webp/decode.h>

#include <algorithm>
#include <array>
#include <bit>
#include <csetjmp>
#include <cstring>
#include <limits>
#include <memory>
#include <string>
#include <string_view>
#include <type_traits>

#include "core/error.h"

namespace sheen {
namespace {

// From 8 to 16 bits, exactly: 255 becomes 65535.
constexpr int kWiden = 257;

bool begins(std::span<const uint8_t> file, std::string_view magic) {
    return file.size() >= magic.size() && std::memcmp(file.data(), magic.data(), magic.size()) == 0;
}

ImageFormat formatOf(std::span<const uint8_t> file) {
    if (begins(file, "\x89PNG\r\n\x1A\n")) {
        return ImageFormat::kPng;
    }
    if (begins(file, "\xFF\xD8")) {
        return ImageFormat::kJpeg;
    }
    if (begins(file, "RIFF") && begins(file.subspan(std::min<size_t>(8, file.size())), "WEBP")) {
        return ImageFormat::kWebp;
    }
    throw DecodeError("it is neither PNG, JPEG nor WebP");
}

// libpng's reader of a file in memory. Errors leave libpng by longjmp, which calls no destructors:
// the functions that set the jump own nothing.
class PngReader {
  public:
    explicit PngReader(std::span<const uint8_t> file)
        : rest_(file),
          png_(png_create_read_struct(PNG_LIBPNG_VER_STRING, this, &onError, &onWarning)),
          info_(png_ == nullptr ? nullptr : png_create_info_struct(png_)) {
        if (info_ == nullptr) {
            png_destroy_read_struct(&png_, nullptr, nullptr);
            throw std::bad_alloc();
        }
        png_set_read_fn(png_, this, &read);
    }
    PngReader(const PngReader&) = delete;
    PngReader& operator=(const PngReader&) = delete;
    ~PngReader() { png_destroy_read_struct(&png_, &info_, nullptr); }

    ImageHeader header() {
        if (!readHeader()) {
            throw DecodeError(message_.data());
        }
        return {.format = ImageFormat::kPng,
                .width = static_cast<int>(png_get_image_width(png_, info_)),
                .height = static_cast<int>(png_get_image_height(png_, info_))};
    }

    // After header(). `rows`: [row][width * 4].
    void readPixels(std::span<png_bytep> rows) {
        if (!readRows(rows.data())) {
            throw DecodeError(message_.data());
        }
    }

  private:
    [[noreturn]] static void onError(png_structp png, png_const_charp what) {
        std::array<char, 128>& message = static_cast<PngReader*>(png_get_error_ptr(png))->message_;
        std::strncpy(message.data(), what, message.size() - 1);
        png_longjmp(png, 1);
    }
    static void onWarning(png_structp, png_const_charp) {}
    static void read(png_structp png, png_bytep out, size_t count) {
        std::span<const uint8_t>& rest = static_cast<PngReader*>(png_get_io_ptr(png))->rest_;
        if (count > rest.size()) {
            png_error(png, "it ends too early");
        }
        std::memcpy(out, rest.data(), count);
        rest = rest.subspan(count);
    }

    bool readHeader() {
        if (setjmp(png_jmpbuf(png_)) != 0) {
            return false;
        }
        // What is too large the caller decides. Texts and profiles are passed over unread.
        constexpr png_uint_32 kAnySize = std::numeric_limits<int>::max();
        png_set_user_limits(png_, kAnySize, kAnySize);
        png_set_keep_unknown_chunks(png_, PNG_HANDLE_CHUNK_NEVER, nullptr, -1);
        png_read_info(png_, info_);
        return true;
    }

    bool readRows(png_bytepp rows) {
        if (setjmp(png_jmpbuf(png_)) != 0) {
            return false;
        }
        png_set_expand_16(png_);
        png_set_gray_to_rgb(png_);
        png_set_add_alpha(png_, 0xffff, PNG_FILLER_AFTER);
        if (std::endian::native == std::endian::little) {
            png_set_swap(png_);
        }
        png_read_image(png_, rows);
        png_read_end(png_, nullptr);
        return true;
    }

    std::span<const uint8_t> rest_;
    std::array<char, 128> message_{};
    png_structp png_;
    png_infop info_;
};

DecodedImage decodePng(std::span<const uint8_t> file) {
    PngReader reader(file);
    const ImageHeader header = reader.header();
    const size_t row_values = 4 * static_cast<size_t>(header.width);
    const auto height = static_cast<size_t>(header.height);
    DecodedImage image{header.width, header.height, std::vector<uint16_t>(row_values * height)};
    std::vector<png_bytep> rows(height);
    for (size_t y = 0; y < height; ++y) {
        rows[y] = reinterpret_cast<png_bytep>(image.rgba.data() + y * row_values);
    }
    reader.readPixels(rows);
    return image;
}

struct TurboJpegDestroyer {
    void operator()(void* handle) const { tjDestroy(handle); }
};

class JpegReader {
  public:
    explicit JpegReader(std::span<const uint8_t> file) : file_(file), handle_(tjInitDecompress()) {
        if (handle_ == nullptr) {
            throw std::bad_alloc();
        }
    }

    ImageHeader header() {
        ImageHeader header{.format = ImageFormat::kJpeg};
        int subsampling = 0;
        check(tjDecompressHeader3(handle_.get(), file_.data(), file_.size(), &header.width,
                                  &header.height, &subsampling, &color_space_));
        if (header.width < 1 || header.height < 1) {
            throw DecodeError("it holds tables and no image");  // no error to libjpeg-turbo
        }
        return header;
    }

    // After header(): whether pixels come as ink, [pixel][4], instead of light, [pixel][3].
    bool isInk() const { return color_space_ == TJCS_CMYK || color_space_ == TJCS_YCCK; }

    // What a warning tells of, data that end early or make no sense, would show as grey; and a
    // small file can ask for thousands of passes over a large image.
    void readPixels(const ImageHeader& header, std::span<uint8_t> out) {
        check(tjDecompress2(handle_.get(), file_.data(), file_.size(), out.data(), header.width, 0,
                            header.height, isInk() ? TJPF_CMYK : TJPF_RGB,
                            TJFLAG_STOPONWARNING | TJFLAG_LIMITSCANS));
    }

  private:
    void check(int result) {
        if (result != 0) {
            throw DecodeError(tjGetErrorStr2(handle_.get()));
        }
    }

    std::span<const uint8_t> file_;
    std::unique_ptr<void, TurboJpegDestroyer> handle_;
    int color_space_ = 0;
};

DecodedImage decodeJpeg(std::span<const uint8_t> file) {
    JpegReader reader(file);
    const ImageHeader header = reader.header();
    const size_t pixels = static_cast<size_t>(header.width) * static_cast<size_t>(header.height);
    const size_t components = reader.isInk() ? 4 : 3;
    std::vector<uint8_t> stored(components * pixels);
    reader.readPixels(header, stored);
    DecodedImage image{header.width, header.height, std::vector<uint16_t>(4 * pixels, 65535)};
    for (size_t i = 0; i < pixels; ++i) {
        for (size_t c = 0; c < 3; ++c) {
            // Ink is stored as the light that it lets through, black last [Adobe Technote 5116].
            const int black = reader.isInk() ? stored[4 * i + 3] : 255;
            image.rgba[4 * i + c] =
                static_cast<uint16_t>(stored[components * i + c] * black * kWiden / 255);
        }
    }
    return image;
}

ImageHeader webpHeader(std::span<const uint8_t> file) {
    WebPBitstreamFeatures features;
    if (WebPGetFeatures(file.data(), file.size(), &features) != VP8_STATUS_OK ||
        features.width < 1 || features.height < 1) {
        throw DecodeError("its WebP header is damaged");
    }
    if (features.has_animation != 0) {
        throw DecodeError("it moves: an animated WebP is no texture");
    }
    return {.format = ImageFormat::kWebp, .width = features.width, .height = features.height};
}

DecodedImage decodeWebp(std::span<const uint8_t> file) {
    const ImageHeader header = webpHeader(file);
    const size_t row = 4 * static_cast<size_t>(header.width);
    std::vector<uint8_t> stored(row * static_cast<size_t>(header.height));
    if (WebPDecodeRGBAInto(file.data(), file.size(), stored.data(), stored.size(),
                           static_cast<int>(row)) == nullptr) {
        throw DecodeError("its WebP data are damaged, or end too early");
    }
    DecodedImage image{header.width, header.height, std::vector<uint16_t>(stored.size())};
    std::transform(stored.begin(), stored.end(), image.rgba.begin(),
                   [](uint8_t byte) { return static_cast<uint16_t>(kWiden * byte); });
    return image;
}

}  // namespace

ImageHeader readImageHeader(std::span<const uint8_t> file) {
    switch (formatOf(file)) {
        case ImageFormat::kPng:
            return PngReader(file).header();
        case ImageFormat::kJpeg:
            return JpegReader(file).header();
        case ImageFormat::kWebp:
            return webpHeader(file);
    }
    throw std::logic_error("unknown image format");
}

DecodedImage decodeImage(std::span<const uint8_t> file) {
    switch (formatOf(file)) {
        case ImageFormat::kPng:
            return decodePng(file);
        case ImageFormat::kJpeg:
            return decodeJpeg(file);
        case ImageFormat::kWebp:
            return decodeWebp(file);
    }
    throw std::logic_error("unknown image format");
}

}  // namespace sheen
