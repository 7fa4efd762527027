// Files: round trips, layers, clamping, atomicity, malformed input.
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFloatAttribute.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfInputFile.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfStringAttribute.h>
#include <gtest/gtest.h>
#include <png.h>
#include <sys/resource.h>

#include <cmath>
#include <csignal>
#include <cstring>

#include "image/atomic_file.h"
#include "image/exr.h"
#include "image/png.h"
#include "image_test_colors.h"
#include "image_test_files.h"

namespace sheen {
namespace {

// Half keeps 11 significant bits.
constexpr float kHalfRelative = 1.0f / 2048.0f;

class ExrTest : public FolderTest {};
class PngTest : public FolderTest {};

constexpr int kWidth = 7;
constexpr int kHeight = 5;

Frame basicFrame() {
    Frame frame;
    frame.direct = colors(kWidth, kHeight, 1.0f);
    frame.indirect = colors(kWidth, kHeight, 0.5f);
    frame.emission = colors(kWidth, kHeight, 0.25f);
    frame.primitive = Image<uint32_t>(kWidth, kHeight, 16777217u);  // not a float's integer
    frame.primitive.at(3, 2) = kNoPrimitive;
    return frame;
}

Frame fullFrame() {
    Frame frame = basicFrame();
    frame.indirect_diffuse = colors(kWidth, kHeight, 0.1f);
    frame.albedo = Image<vec3>(kWidth, kHeight, vec3(0.5f));
    frame.normal = Image<vec3>(kWidth, kHeight, vec3(0.0f, 0.6f, 0.8f));
    frame.position = colors(kWidth, kHeight, 1000.1f);
    frame.roughness = Image<float>(kWidth, kHeight, 0.5f);
    frame.depth = Image<float>(kWidth, kHeight, 1234.567f);
    frame.depth.at(3, 2) = kInfinity;
    frame.weight = Image<float>(kWidth, kHeight, 1e6f);
    frame.records = Image<float>(kWidth, kHeight, 2049.0f);
    return frame;
}

Frame referenceFrame() {
    Frame frame = fullFrame();
    frame.indirect_variance = colors(kWidth, kHeight, 1e-9f);
    frame.indirect_diffuse_variance = colors(kWidth, kHeight, 1e-10f);
    frame.direct_variance = colors(kWidth, kHeight, 1e-11f);
    return frame;
}

void expectNear(const Image<vec3>& a, const Image<vec3>& b, float relative) {
    ASSERT_EQ(a.pixels.size(), b.pixels.size());
    for (size_t i = 0; i < a.pixels.size(); ++i) {
        for (int c = 0; c < 3; ++c) {
            ASSERT_NEAR(a.pixels[i][c], b.pixels[i][c], relative * std::abs(b.pixels[i][c]));
        }
    }
}

TEST_F(ExrTest, basicRoundTrip) {
    const Frame frame = basicFrame();
    writeExr(file("a.exr"), frame, ExrLayers::kBasic);
    const LoadedExr exr = readExr(file("a.exr"));
    EXPECT_EQ(exr.width, kWidth);
    EXPECT_EQ(exr.height, kHeight);
    expectNear(colorLayer(exr, "direct"), frame.direct, kHalfRelative);
    expectNear(colorLayer(exr, "indirect"), frame.indirect, kHalfRelative);
    expectNear(colorLayer(exr, "beauty"), beauty(frame), kHalfRelative);
    EXPECT_EQ(exr.primitive.pixels, frame.primitive.pixels);
    EXPECT_EQ(exr.scalars.at("A").at(3, 2), 0.0f);
    EXPECT_EQ(exr.scalars.at("A").at(2, 2), 1.0f);
    EXPECT_EQ(fileCount(), 1);
}

TEST_F(ExrTest, beautyIsTheSumOfItsLayers) {
    const Frame frame = basicFrame();
    expectNear(beauty(frame), colors(kWidth, kHeight, 1.75f), 1e-6f);
    Frame only_direct;
    only_direct.direct = frame.direct;
    only_direct.primitive = frame.primitive;
    expectNear(beauty(only_direct), frame.direct, 0.0f);
}

TEST_F(ExrTest, basicLeavesOutWhatOnlyAllHolds) {
    writeExr(file("basic.exr"), fullFrame(), ExrLayers::kBasic);
    writeExr(file("all.exr"), fullFrame(), ExrLayers::kAll);
    const LoadedExr basic = readExr(file("basic.exr"));
    const LoadedExr all = readExr(file("all.exr"));
    for (const char* layer : {"indirect_diffuse", "emission", "albedo", "N", "P"}) {
        EXPECT_EQ(basic.colors.count(layer), 0u) << layer;
        EXPECT_EQ(all.colors.count(layer), 1u) << layer;
    }
    for (const char* channel : {"roughness.Y", "Z", "weight.Y", "records.Y"}) {
        EXPECT_EQ(basic.scalars.count(channel), 0u) << channel;
        EXPECT_EQ(all.scalars.count(channel), 1u) << channel;
    }
    EXPECT_EQ(all.colors.count("variance"), 0u);
}

TEST_F(ExrTest, geometryIsExact) {
    const Frame frame = fullFrame();
    writeExr(file("a.exr"), frame, ExrLayers::kAll);
    const LoadedExr exr = readExr(file("a.exr"));
    EXPECT_EQ(colorLayer(exr, "P").pixels, frame.position.pixels);
    EXPECT_EQ(exr.scalars.at("Z").pixels, frame.depth.pixels);
    EXPECT_EQ(exr.scalars.at("weight.Y").pixels, frame.weight.pixels);
    EXPECT_EQ(exr.scalars.at("records.Y").pixels, frame.records.pixels);
}

TEST_F(ExrTest, notesAreAttributesOfTheHeader) {
    writeExr(file("a.exr"), basicFrame(), ExrLayers::kBasic,
             {.texts = {{"software", "a"}}, .numbers = {{"whiteLuminance", 2.5f}}});
    const Imf::InputFile in(file("a.exr").c_str());
    EXPECT_EQ(in.header().typedAttribute<Imf::StringAttribute>("software").value(), "a");
    EXPECT_EQ(in.header().typedAttribute<Imf::FloatAttribute>("whiteLuminance").value(), 2.5f);
}

TEST_F(ExrTest, channelTypes) {
    writeExr(file("cached.exr"), fullFrame(), ExrLayers::kAll);
    writeExr(file("reference.exr"), referenceFrame(), ExrLayers::kAll);
    const Imf::InputFile cached(file("cached.exr").c_str());
    const Imf::InputFile reference(file("reference.exr").c_str());
    EXPECT_EQ(cached.header().channels()["indirect.G"].type, Imf::HALF);
    EXPECT_EQ(reference.header().channels()["indirect.G"].type, Imf::FLOAT);
    EXPECT_EQ(cached.header().channels()["Z"].type, Imf::FLOAT);
    EXPECT_EQ(cached.header().channels()["primitive.id"].type, Imf::UINT);
    EXPECT_EQ(cached.header().compression(), Imf::ZIP_COMPRESSION);
}

TEST_F(ExrTest, referenceIsExactAndBringsItsVariances) {
    const Frame frame = referenceFrame();
    writeExr(file("a.exr"), frame, ExrLayers::kBasic);
    const LoadedExr exr = readExr(file("a.exr"));
    EXPECT_EQ(colorLayer(exr, "indirect").pixels, frame.indirect.pixels);
    EXPECT_EQ(colorLayer(exr, "indirect_diffuse").pixels, frame.indirect_diffuse.pixels);
    EXPECT_EQ(colorLayer(exr, "variance").pixels, frame.indirect_variance.pixels);
    EXPECT_EQ(colorLayer(exr, "variance_diffuse").pixels, frame.indirect_diffuse_variance.pixels);
    EXPECT_EQ(colorLayer(exr, "variance_direct").pixels, frame.direct_variance.pixels);
}

TEST_F(ExrTest, valuesBeyondHalfAreKeptInFloats) {
    Frame frame = basicFrame();
    frame.indirect.at(0, 0) = vec3(1e6f, -1e30f, 0.1f);
    frame.direct.at(0, 0) = vec3(65504.0f, kInfinity, 0.0f);
    writeExr(file("a.exr"), frame, ExrLayers::kBasic);
    const LoadedExr exr = readExr(file("a.exr"));
    EXPECT_EQ(colorLayer(exr, "indirect").pixels, frame.indirect.pixels);
    EXPECT_EQ(colorLayer(exr, "direct").at(0, 0), frame.direct.at(0, 0));
    const Imf::InputFile written(file("a.exr").c_str());
    EXPECT_EQ(written.header().channels()["direct.G"].type, Imf::HALF) << "this one's values fit";
}

TEST_F(ExrTest, dimLightKeepsItsDigits) {
    // As in a scene of millimetres.
    Frame frame = basicFrame();
    for (vec3& pixel : frame.indirect.pixels) {
        pixel *= 1e-7f;
    }
    frame.indirect.at(0, 0) = vec3(1.1e-6f, 3.3e-9f, 0.0f);
    writeExr(file("a.exr"), frame, ExrLayers::kBasic);
    EXPECT_EQ(colorLayer(readExr(file("a.exr")), "indirect").pixels, frame.indirect.pixels);
}

TEST_F(ExrTest, notANumberStaysVisible) {
    Frame frame = basicFrame();
    frame.indirect.at(1, 1).y = std::nanf("");
    writeExr(file("a.exr"), frame, ExrLayers::kBasic);
    const LoadedExr exr = readExr(file("a.exr"));
    EXPECT_TRUE(std::isnan(colorLayer(exr, "indirect").at(1, 1).y));
}

TEST_F(ExrTest, onePixel) {
    Frame frame;
    frame.primitive = Image<uint32_t>(1, 1, kNoPrimitive);
    frame.direct = Image<vec3>(1, 1, vec3(2.0f));
    writeExr(file("a.exr"), frame, ExrLayers::kAll);
    EXPECT_EQ(colorLayer(readExr(file("a.exr")), "beauty").at(0, 0), vec3(2.0f));
}

TEST_F(ExrTest, readsFilesThatAreNotInTheWay) {
    writeText(file("a.exr"), "an older file, longer than nothing");
    writeExr(file("a.exr"), basicFrame(), ExrLayers::kBasic);
    EXPECT_EQ(readExr(file("a.exr")).width, kWidth);
    EXPECT_EQ(fileCount(), 1);
}

TEST_F(ExrTest, layersOfDifferentSizesAreABug) {
    Frame frame = basicFrame();
    frame.indirect = Image<vec3>(kWidth + 1, kHeight);
    EXPECT_THROW(writeExr(file("a.exr"), frame, ExrLayers::kBasic), std::logic_error);
    EXPECT_EQ(fileCount(), 0);
}

TEST_F(ExrTest, readRejectsMissing) {
    expectError(ExitCode::kInput, "no such file", [&] { readExr(file("none.exr")); });
}

TEST_F(ExrTest, readRejectsFolder) {
    expectError(ExitCode::kInput, "is a directory", [&] { readExr(folder_.string()); });
}

TEST_F(ExrTest, readRejectsOtherFormats) {
    writeText(file("a.exr"), "not an image");
    expectError(ExitCode::kInput, "not an EXR file", [&] { readExr(file("a.exr")); });
    writeText(file("empty.exr"), "");
    expectError(ExitCode::kInput, "not an EXR file", [&] { readExr(file("empty.exr")); });
}

TEST_F(ExrTest, readRejectsEveryTruncation) {
    writeExr(file("a.exr"), fullFrame(), ExrLayers::kAll);
    const std::string whole = textOf(file("a.exr"));
    for (size_t size = 0; size < whole.size(); size += 1 + whole.size() / 97) {
        writeText(file("cut.exr"), whole.substr(0, size));
        EXPECT_THROW(readExr(file("cut.exr")), Error) << size << " of " << whole.size();
    }
}

TEST_F(ExrTest, readSurvivesDamage) {
    writeExr(file("a.exr"), fullFrame(), ExrLayers::kAll);
    const std::string whole = textOf(file("a.exr"));
    for (size_t at = 0; at < whole.size(); at += 1 + whole.size() / 199) {
        std::string damaged = whole;
        damaged[at] = static_cast<char>(damaged[at] ^ 0x5a);
        writeText(file("damaged.exr"), damaged);
        try {
            readExr(file("damaged.exr"));
        } catch (const Error&) {
            // Either answer is right: some bytes are pixels, and no checksum covers the header.
        }
    }
}

TEST_F(ExrTest, missingLayersAreNamed) {
    Frame frame = basicFrame();
    frame.indirect = {};
    writeExr(file("a.exr"), frame, ExrLayers::kBasic);
    const LoadedExr exr = readExr(file("a.exr"));
    expectError(ExitCode::kInput, "no layer 'indirect'; the file has: beauty, direct",
                [&] { colorLayer(exr, "indirect"); });
}

// A file of another program: `names` as float channels, with a data window off the origin.
void writeForeign(const std::string& path, const std::vector<std::string>& names) {
    constexpr int kSide = 4;
    const Imath::Box2i window({-3, 5}, {-3 + kSide - 1, 5 + kSide - 1});
    Imf::Header header(window, window);
    Imf::FrameBuffer pixels;
    std::vector<float> values(kSide * kSide);
    for (size_t i = 0; i < values.size(); ++i) {
        values[i] = static_cast<float>(i);
    }
    for (const std::string& name : names) {
        header.channels().insert(name, Imf::Channel(Imf::FLOAT));
        char* base = reinterpret_cast<char*>(values.data()) -
                     static_cast<ptrdiff_t>(sizeof(float)) * (window.min.x + window.min.y * kSide);
        pixels.insert(name, Imf::Slice(Imf::FLOAT, base, sizeof(float), kSide * sizeof(float)));
    }
    Imf::OutputFile output(path.c_str(), header);
    output.setFrameBuffer(pixels);
    output.writePixels(kSide);
}

TEST_F(ExrTest, readsOtherProgramsFiles) {
    writeForeign(file("a.exr"),
                 {"R", "G", "B", "mask", "view.left.R", "view.left.G", "view.left.B"});
    const LoadedExr exr = readExr(file("a.exr"));
    EXPECT_EQ(colorLayer(exr, "beauty").at(1, 2), vec3(9.0f));
    EXPECT_EQ(colorLayer(exr, "view.left").at(3, 3), vec3(15.0f));
    EXPECT_EQ(exr.scalars.at("mask").at(0, 1), 4.0f);
    EXPECT_TRUE(exr.primitive.empty());
}

TEST_F(ExrTest, readRejectsIncompleteLayers) {
    writeForeign(file("a.exr"), {"indirect.R", "indirect.B"});
    expectError(ExitCode::kInput, "layer 'indirect' lacks one of the channels R, G, B",
                [&] { readExr(file("a.exr")); });
}

void writeWord(std::string& bytes, size_t at, int32_t value) {
    std::memcpy(bytes.data() + at, &value, sizeof(value));
}

// A damaged window would take memory for pixels that cannot be in the file.
TEST_F(ExrTest, readRejectsHeadersThatPromiseTooMuch) {
    writeForeign(file("a.exr"), {"R", "G", "B"});
    std::string bytes = textOf(file("a.exr"));
    const std::string attribute =
        std::string("dataWindow\0box2i\0", 17) + std::string("\x10\0\0\0", 4);
    const size_t window = bytes.find(attribute) + attribute.size();
    ASSERT_LT(window, bytes.size());
    writeWord(bytes, window, 0);
    writeWord(bytes, window + 8, 16383);
    writeText(file("a.exr"), bytes);
    expectError(ExitCode::kInput, "pixels that its header promises",
                [&] { readExr(file("a.exr")); });
}

TEST_F(ExrTest, fullDiskIsReportedAndLeavesNothing) {
    // A file size limit stands in for a full disk: the write fails in the same place.
    struct rlimit before {};
    ASSERT_EQ(getrlimit(RLIMIT_FSIZE, &before), 0);
    const auto handler = std::signal(SIGXFSZ, SIG_IGN);
    struct rlimit small = before;
    small.rlim_cur = 100;
    ASSERT_EQ(setrlimit(RLIMIT_FSIZE, &small), 0);
    expectError(ExitCode::kEnvironment, "a.exr: cannot write: ", [&] {
        writeExr(file("a.exr"), fullFrame(), ExrLayers::kAll);
    });
    expectError(ExitCode::kEnvironment, "a.png: cannot write: ", [&] {
        writePng(file("a.png"), colors(200, 200, 1.0f), 0.0f);
    });
    setrlimit(RLIMIT_FSIZE, &before);
    std::signal(SIGXFSZ, handler);
    EXPECT_EQ(fileCount(), 0);
}

TEST_F(PngTest, roundTrip) {
    Image<Rgb8> image(3, 2);
    image.at(0, 0) = {255, 0, 0};
    image.at(2, 1) = {1, 2, 3};
    writePng(file("a.png"), image);
    png_image png{};
    png.version = PNG_IMAGE_VERSION;
    ASSERT_NE(png_image_begin_read_from_file(&png, file("a.png").c_str()), 0);
    EXPECT_EQ(png.width, 3u);
    EXPECT_EQ(png.height, 2u);
    png.format = PNG_FORMAT_RGB;
    std::vector<uint8_t> bytes(PNG_IMAGE_SIZE(png));
    ASSERT_NE(png_image_finish_read(&png, nullptr, bytes.data(), 0, nullptr), 0);
    EXPECT_EQ(std::vector<uint8_t>(bytes.begin(), bytes.begin() + 3),
              (std::vector<uint8_t>{255, 0, 0}));
    EXPECT_EQ(std::vector<uint8_t>(bytes.end() - 3, bytes.end()), (std::vector<uint8_t>{1, 2, 3}));
    EXPECT_EQ(fileCount(), 1);
}

TEST(PngBytes, fewColorsOrManyReadBackEqual) {
    for (const int colors : {1, 2, 256, 257, 4000}) {
        Image<Rgb8> image(80, 50);
        for (int i = 0; i < image.count(); ++i) {
            const int color = i % colors;
            image.pixels[static_cast<size_t>(i)] = {static_cast<uint8_t>(color),
                                                    static_cast<uint8_t>(color / 256), 7};
        }
        const std::string file = pngBytes(image);
        png_image png{};
        png.version = PNG_IMAGE_VERSION;
        ASSERT_NE(png_image_begin_read_from_memory(&png, file.data(), file.size()), 0);
        EXPECT_EQ((png.format & PNG_FORMAT_FLAG_COLORMAP) != 0, colors <= 256) << colors;
        png.format = PNG_FORMAT_RGB;
        std::vector<Rgb8> pixels(image.pixels.size());
        ASSERT_EQ(PNG_IMAGE_SIZE(png), pixels.size() * sizeof(Rgb8));
        ASSERT_NE(png_image_finish_read(&png, nullptr, pixels.data(), 0, nullptr), 0);
        for (size_t i = 0; i < pixels.size(); ++i) {
            ASSERT_EQ(std::memcmp(&pixels[i], &image.pixels[i], sizeof(Rgb8)), 0) << colors;
        }
    }
}

TEST_F(PngTest, isTransparentWhereNothingIsSeenUnlessASkyShows) {
    Frame frame;
    frame.direct = Image<vec3>(2, 1, vec3(0.5f));
    frame.primitive = Image<uint32_t>(2, 1, 0);
    frame.primitive.at(1, 0) = kNoPrimitive;
    const auto alphas = [&] {
        writePng(file("a.png"), frame, 0.0f);
        png_image png{};
        png.version = PNG_IMAGE_VERSION;
        EXPECT_NE(png_image_begin_read_from_file(&png, file("a.png").c_str()), 0);
        png.format = PNG_FORMAT_RGBA;
        std::vector<uint8_t> bytes(PNG_IMAGE_SIZE(png));
        EXPECT_NE(png_image_finish_read(&png, nullptr, bytes.data(), 0, nullptr), 0);
        EXPECT_EQ(bytes[0], 181);  // 0.5 less the curve's toe, whatever covers how much of it
        return std::vector<int>{bytes[3], bytes[7]};
    };
    EXPECT_EQ(alphas(), (std::vector<int>{255, 0}));
    EXPECT_EQ(alpha(frame).pixels, (std::vector<float>{1.0f, 0.0f}));
    frame.coverage = Image<float>(2, 1, 0.25f);
    frame.direct.at(0, 0) = vec3(0.125f);
    EXPECT_EQ(alphas(), (std::vector<int>{64, 64}));
    frame.direct.at(0, 0) = vec3(0.5f);
    frame.shows_sky = true;
    EXPECT_EQ(alphas(), (std::vector<int>{255, 255}));
    EXPECT_EQ(alpha(frame).pixels, (std::vector<float>{1.0f, 1.0f}));
}

TEST_F(PngTest, frame) {
    writePng(file("a.png"), basicFrame(), std::nullopt);
    EXPECT_EQ(textOf(file("a.png")).substr(1, 3), "PNG");
}

}  // namespace
}  // namespace sheen
