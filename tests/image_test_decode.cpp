// PNG, JPEG and WebP files that others wrote: the values as stored, or an error.
#include <gtest/gtest.h>
#include <png.h>
#include <webp/encode.h>

#include <string>

#include "encoded_images.h"
#include "image/decode.h"

namespace sheen {
namespace {

struct Png {
    int color_type = PNG_COLOR_TYPE_RGB;
    int bits = 8;
    int width = 0;
    std::vector<std::vector<uint8_t>> rows;  // as the file holds them
    int interlace = PNG_INTERLACE_NONE;
    std::vector<png_color> palette = {};
    bool gamma_of_one = false;
};

std::vector<uint8_t> encodePng(Png png) {
    std::vector<uint8_t> file;
    png_structp out = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, nullptr, nullptr);
    png_infop info = png_create_info_struct(out);
    const auto append = [](png_structp p, png_bytep data, size_t size) {
        auto* bytes = static_cast<std::vector<uint8_t>*>(png_get_io_ptr(p));
        bytes->insert(bytes->end(), data, data + size);
    };
    png_set_write_fn(out, &file, append, nullptr);
    png_set_IHDR(out, info, static_cast<png_uint_32>(png.width),
                 static_cast<png_uint_32>(png.rows.size()), png.bits, png.color_type, png.interlace,
                 PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
    if (!png.palette.empty()) {
        png_set_PLTE(out, info, png.palette.data(), static_cast<int>(png.palette.size()));
        const png_byte transparent = 0;
        png_set_tRNS(out, info, &transparent, 1, nullptr);
    }
    if (png.gamma_of_one) {
        png_set_gAMA(out, info, 1.0);
    }
    std::vector<png_bytep> rows;
    for (std::vector<uint8_t>& row : png.rows) {
        rows.push_back(row.data());
    }
    png_set_rows(out, info, rows.data());
    png_write_png(out, info, PNG_TRANSFORM_IDENTITY, nullptr);
    png_destroy_write_struct(&out, &info);
    return file;
}

// Red, green and blue, or alpha alone.
enum class Channels { kColors, kAlpha };

std::vector<int> decoded(const std::vector<uint8_t>& file, Channels wanted = Channels::kColors) {
    const ImageHeader header = readImageHeader(file);
    const DecodedImage image = decodeImage(file);
    EXPECT_EQ(image.width, header.width);
    EXPECT_EQ(image.height, header.height);
    EXPECT_EQ(image.rgba.size(), 4u * static_cast<size_t>(header.width * header.height));
    std::vector<int> values;
    for (size_t i = 0; i < image.rgba.size(); ++i) {
        if ((i % 4 == 3) == (wanted == Channels::kAlpha)) {
            values.push_back(image.rgba[i]);
        }
    }
    return values;
}

// Eight bits in sixteen.
constexpr int wide(int value) { return 257 * value; }

TEST(DecodePng, AlphaIsKeptAndOneWhereThereIsNone) {
    EXPECT_EQ(
        decoded(encodePng({PNG_COLOR_TYPE_GRAY_ALPHA, 8, 1, {{9, 0}, {9, 51}}}), Channels::kAlpha),
        (std::vector<int>{0, wide(51)}));
    EXPECT_EQ(
        decoded(encodePng({.width = 1, .rows = {{1, 2, 3}, {255, 128, 0}}}), Channels::kAlpha),
        (std::vector<int>{65535, 65535}));
}

TEST(DecodePng, EveryKindGivesWhatIsStored) {
    EXPECT_EQ(decoded(encodePng({.width = 1, .rows = {{1, 2, 3}, {255, 128, 0}}})),
              (std::vector<int>{wide(1), wide(2), wide(3), 65535, wide(128), 0}));
    EXPECT_EQ(
        decoded(encodePng({.bits = 16, .width = 1, .rows = {{0x12, 0x34, 0, 1, 0xff, 0xfe}}})),
        (std::vector<int>{0x1234, 1, 0xfffe}));
    EXPECT_EQ(decoded(encodePng({PNG_COLOR_TYPE_GRAY, 1, 2, {{0x40}}})),
              (std::vector<int>{0, 0, 0, 65535, 65535, 65535}));
    EXPECT_EQ(decoded(encodePng({PNG_COLOR_TYPE_GRAY, 4, 1, {{0x70}}})),
              (std::vector<int>(3, wide(0x77))));
    EXPECT_EQ(decoded(encodePng({PNG_COLOR_TYPE_GRAY_ALPHA, 8, 1, {{9, 0}}})),
              (std::vector<int>(3, wide(9))));
}

TEST(DecodePng, NeitherAlphaNorGammaChangesColors) {
    EXPECT_EQ(decoded(encodePng({PNG_COLOR_TYPE_RGBA, 8, 1, {{1, 2, 3, 0}}})),
              (std::vector<int>{wide(1), wide(2), wide(3)}));
    EXPECT_EQ(decoded(encodePng({PNG_COLOR_TYPE_PALETTE,
                                 2,
                                 2,
                                 {{0x10}},
                                 PNG_INTERLACE_NONE,
                                 {{7, 8, 9}, {10, 11, 12}}})),
              (std::vector<int>{wide(7), wide(8), wide(9), wide(10), wide(11), wide(12)}));
    EXPECT_EQ(decoded(encodePng({.width = 1, .rows = {{1, 2, 3}}, .gamma_of_one = true})),
              (std::vector<int>{wide(1), wide(2), wide(3)}));
}

TEST(DecodePng, InterlacedIsTheSameImage) {
    Png png{PNG_COLOR_TYPE_GRAY, 8, 9, {}};
    for (int y = 0; y < 9; ++y) {
        std::vector<uint8_t>& row = png.rows.emplace_back();
        for (int x = 0; x < 9; ++x) {
            row.push_back(static_cast<uint8_t>(9 * y + x));
        }
    }
    const std::vector<int> expected = decoded(encodePng(png));
    EXPECT_EQ(expected[3 * 80], wide(80));
    png.interlace = PNG_INTERLACE_ADAM7;
    EXPECT_EQ(decoded(encodePng(png)), expected);
}

TEST(DecodeJpeg, GreyColorAndInkGiveWhatIsStored) {
    constexpr int kRounding = wide(2);  // of two colour spaces, at the best quality
    const auto expectFlat = [](const std::vector<uint8_t>& file, std::vector<int> expected) {
        const std::vector<int> values = decoded(file);
        ASSERT_EQ(values.size(), 3u * 9 * 10);
        for (size_t i = 0; i < values.size(); ++i) {
            ASSERT_NEAR(values[i], wide(expected[i % 3]), kRounding) << i;
        }
    };
    const auto flat = [](std::vector<uint8_t> pixel) {
        std::vector<uint8_t> pixels;
        for (int i = 0; i < 9 * 10; ++i) {
            pixels.insert(pixels.end(), pixel.begin(), pixel.end());
        }
        return pixels;
    };
    expectFlat(encodeJpeg(flat({77}), 9, 1), {77, 77, 77});
    expectFlat(encodeJpeg(flat({200, 100, 50}), 9, 3), {200, 100, 50});
    expectFlat(encodeJpeg(flat({200, 100, 50}), 9, 3, TJFLAG_PROGRESSIVE), {200, 100, 50});
    expectFlat(encodeJpeg(flat({200, 100, 50, 255}), 9, 4), {200, 100, 50});
    expectFlat(encodeJpeg(flat({200, 100, 50, 51}), 9, 4), {40, 20, 10});
}

std::vector<uint8_t> noise(size_t size) {
    std::vector<uint8_t> values;
    uint32_t state = 1;
    for (size_t i = 0; i < size; ++i) {
        state = state * 1664525 + 1013904223;
        values.push_back(static_cast<uint8_t>(state >> 24));
    }
    return values;
}

// `quality`: of 100; 100: lossless.
std::vector<uint8_t> encodeWebp(const std::vector<uint8_t>& rgb, int width, float quality) {
    uint8_t* out = nullptr;
    const int height = static_cast<int>(rgb.size()) / (3 * width);
    const size_t size = quality < 100.0f
                            ? WebPEncodeRGB(rgb.data(), width, height, 3 * width, quality, &out)
                            : WebPEncodeLosslessRGB(rgb.data(), width, height, 3 * width, &out);
    std::vector<uint8_t> file(out, out + size);
    WebPFree(out);
    return file;
}

std::vector<std::vector<uint8_t>> soundFiles() {
    return {encodePng({.width = 5, .rows = {noise(15), noise(15)}}), encodeJpeg(noise(300), 10, 3),
            encodeJpeg(noise(300), 10, 3, TJFLAG_PROGRESSIVE), encodeWebp(noise(300), 10, 100.0f),
            encodeWebp(noise(300), 10, 50.0f)};
}

TEST(DecodeWebp, IsAsStored) {
    const std::vector<uint8_t> rgb = noise(300);
    const std::vector<int> values = decoded(encodeWebp(rgb, 10, 100.0f));
    ASSERT_EQ(values.size(), rgb.size());
    for (size_t i = 0; i < rgb.size(); ++i) {
        EXPECT_EQ(values[i], 257 * rgb[i]);
    }
    const std::vector<int> lossy = decoded(encodeWebp(std::vector<uint8_t>(300, 90), 10, 50.0f));
    for (const int value : lossy) {
        EXPECT_NEAR(value, 257 * 90, 257 * 4);
    }
}

TEST(DecodeDamaged, FilesThatEndTooEarlyAreErrors) {
    for (const std::vector<uint8_t>& file : soundFiles()) {
        // The last marker tells nothing more.
        for (size_t size = 0; size + 2 < file.size(); ++size) {
            const std::vector<uint8_t> part(file.begin(),
                                            file.begin() + static_cast<std::ptrdiff_t>(size));
            EXPECT_THROW(decodeImage(part), DecodeError) << size << " of " << file.size();
        }
    }
}

TEST(DecodeDamaged, ChangedBytesAreAnErrorOrAnImageOfTheSizeTold) {
    for (const std::vector<uint8_t>& file : soundFiles()) {
        for (size_t i = 0; i < file.size(); ++i) {
            for (const uint8_t mask : {1, 0x40, 0xff}) {
                std::vector<uint8_t> changed = file;
                changed[i] ^= mask;
                try {
                    if (readImageHeader(changed).height < 1000) {
                        decoded(changed);
                    }
                } catch (const DecodeError& error) {
                    EXPECT_STRNE(error.what(), "");
                }
            }
        }
    }
}

// A byte of a PNG that is not as written, and a table whose codes cannot be.
TEST(DecodeDamaged, SaysWhatIsWrong) {
    const auto reason = [](const std::vector<uint8_t>& file) -> std::string {
        try {
            decodeImage(file);
        } catch (const DecodeError& error) {
            return error.what();
        }
        return "";
    };
    std::vector<uint8_t> png = soundFiles()[0];
    png[19] ^= 1;
    EXPECT_NE(reason(png).find("CRC"), std::string::npos) << reason(png);
    png.resize(20);
    EXPECT_EQ(reason(png), "it ends too early");
    EXPECT_EQ(reason({'G', 'I', 'F', '8', '9', 'a'}), "it is neither PNG, JPEG nor WebP");
    EXPECT_EQ(reason({0xff, 0xd8, 0xff, 0xd9}), "it holds tables and no image");
    EXPECT_EQ(reason({}), "it is neither PNG, JPEG nor WebP");
}

// Each pass over an image costs its whole size, however few bytes ask for it.
TEST(DecodeDamaged, JpegOfThousandsOfPassesIsAnError) {
    const std::vector<uint8_t> file = encodeJpeg(noise(300), 10, 3, TJFLAG_PROGRESSIVE);
    const std::vector<uint8_t> start = {0xff, 0xda};
    const auto scan = std::find_end(file.begin(), file.end(), start.begin(), start.end());
    ASSERT_NE(scan, file.end());
    std::vector<uint8_t> many(file.begin(), scan);
    for (int i = 0; i < 5000; ++i) {
        many.insert(many.end(), scan, file.end() - 2);
    }
    many.insert(many.end(), {0xff, 0xd9});
    EXPECT_EQ(readImageHeader(many).width, 10);
    EXPECT_THROW(decodeImage(many), DecodeError);
}

}  // namespace
}  // namespace sheen
