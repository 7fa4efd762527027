// Writes what the fuzzers start from: make_fuzz_seeds DIRECTORY makes the folders scene, exr,
// image, point and options of small sound files in it, and the dictionary gltf.dict.
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfCompression.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfOutputFile.h>
#include <OpenEXR/ImfTiledOutputFile.h>

#include <filesystem>
#include <fstream>

#include "chart/point_file.h"
#include "encoded_images.h"
#include "fuzz/gltf_words.h"
#include "fuzz/seeds.h"
#include "image/exr.h"
#include "image/png.h"

namespace sheen::fuzz {
namespace {

namespace fs = std::filesystem;

constexpr int kSide = 12;  // of images: more than one 8 x 8 block

void writeFile(const fs::path& path, const std::string& bytes) {
    std::ofstream(path, std::ios::binary) << bytes;
}

void makeScenes(const fs::path& folder) {
    for (const auto& [name, bytes] : sceneSeeds()) {
        writeFile(folder / name, bytes);
    }
}

Frame frame() {
    Frame frame;
    frame.direct = Image<vec3>(kSide, kSide, vec3(0.5f, 1.0f, 2.0f));
    frame.direct.at(3, 4) = vec3(7.0f);
    frame.indirect = frame.direct;
    frame.emission = frame.direct;
    frame.primitive = Image<uint32_t>(kSide, kSide, 3u);
    frame.depth = Image<float>(kSide, kSide, 2.5f);
    return frame;
}

// A file as other programs write them: `make` opens it, by lines or by tiles.
template <class Make>
void makeForeign(Imf::Compression compression, Imf::PixelType type, const Make& make) {
    const Imath::Box2i window({-2, 5}, {kSide - 3, kSide + 4});
    Imf::Header header(window, window);
    header.compression() = compression;
    std::vector<uint32_t> values(kSide * kSide, 0x3c003c00u);  // 1 as half, about 0.008 as float
    const size_t size = type == Imf::HALF ? 2 : 4;
    Imf::FrameBuffer pixels;
    for (const char* name : {"R", "G", "B", "mask"}) {
        header.channels().insert(name, Imf::Channel(type));
        char* base = reinterpret_cast<char*>(values.data()) -
                     static_cast<ptrdiff_t>(size) * (window.min.x + window.min.y * kSide);
        pixels.insert(name, Imf::Slice(type, base, size, size * kSide));
    }
    make(header, pixels);
}

void makeExrs(const fs::path& folder) {
    writeExr(folder / "basic.exr", frame(), ExrLayers::kBasic);
    writeExr(folder / "all.exr", frame(), ExrLayers::kAll);
    for (int compression = 0; compression < Imf::NUM_COMPRESSION_METHODS; ++compression) {
        for (const Imf::PixelType type : {Imf::HALF, Imf::FLOAT, Imf::UINT}) {
            makeForeign(static_cast<Imf::Compression>(compression), type,
                        [&](const Imf::Header& header, const Imf::FrameBuffer& pixels) {
                            const std::string name =
                                fmt::format("lines-{}-{}.exr", compression, static_cast<int>(type));
                            Imf::OutputFile file((folder / name).c_str(), header);
                            file.setFrameBuffer(pixels);
                            file.writePixels(kSide);
                        });
        }
        makeForeign(static_cast<Imf::Compression>(compression), Imf::HALF,
                    [&](Imf::Header& header, const Imf::FrameBuffer& pixels) {
                        header.setTileDescription({8, 8, Imf::MIPMAP_LEVELS});
                        const std::string name = fmt::format("tiles-{}.exr", compression);
                        Imf::TiledOutputFile file((folder / name).c_str(), header);
                        file.setFrameBuffer(pixels);
                        for (int level = 0; level < file.numLevels(); ++level) {
                            file.writeTiles(0, file.numXTiles(level) - 1, 0,
                                            file.numYTiles(level) - 1, level);
                        }
                    });
    }
}

void makeImages(const fs::path& folder) {
    Image<Rgb8> few(kSide, kSide);
    few.at(3, 4) = {200, 100, 50};
    Image<Rgb8> many(2 * kSide, kSide);  // more colours than a palette has
    std::vector<uint8_t> values;
    for (int i = 0; i < many.count(); ++i) {
        const auto shade = static_cast<uint8_t>(i);
        many.pixels[static_cast<size_t>(i)] = {shade, static_cast<uint8_t>(i / 256), 9};
        values.insert(values.end(), {shade, 100, 50, 200});
    }
    writeFile(folder / "palette.png", pngBytes(few));
    writeFile(folder / "rgb.png", pngBytes(many));
    for (const int components : {1, 3, 4}) {
        for (const int flags : {0, TJFLAG_PROGRESSIVE}) {
            const std::vector<uint8_t> bytes =
                encodeJpeg(values, 4 * 2 * kSide / components, components, flags);
            writeFile(folder / fmt::format("{}-{}.jpg", components, flags),
                      std::string(bytes.begin(), bytes.end()));
        }
    }
}

void makePoints(const fs::path& folder) {
    const StoredPoint point = {
        .key = {.scene = "0123456789abcdef",
                .camera = 1,
                .width = 64,
                .height = 48,
                .arguments = {"--method", "radiance", "--accuracy", "0.4"},
                .gl = "osmesa"},
        .measured = {.host = {.version = "0.1", .build = "b", .cpu = "c", .threads = 2},
                     .runs = {{1.5, {{"load", 0.5}, {"other", 1.0}}},
                              {1.25, {{"load", 0.25}, {"other", 1.0}}},
                              {2.0, {}}},
                     .records = 100,
                     .gl_renderer = "llvmpipe"}};
    writeFile(folder / "point.json", jsonText(point));
}

void makeOptions(const fs::path& folder) {
    for (const char* value : {"640x480", "auto", "-2.5", "7", "image.exr", "image.PNG", "1e3"}) {
        writeFile(folder / fmt::format("{}.txt", fileNamePart(value)), value);
    }
}

void makeDictionary(const std::string& path) {
    std::string text;
    for (const char* key : kKeys) {
        text += fmt::format("\"\\\"{}\\\":\"\n", key);
    }
    for (const double number : kNumbers) {
        text += fmt::format("\"{}\"\n", number);
    }
    writeFile(path, text);
}

}  // namespace
}  // namespace sheen::fuzz

int main(int argc, char** argv) {
    using namespace sheen::fuzz;
    if (argc != 2) {
        fmt::print(stderr, "usage: make_fuzz_seeds DIRECTORY\n");
        return 2;
    }
    const fs::path root = argv[1];
    for (const auto& [name, make] : {std::pair{"scene", &makeScenes},
                                     {"exr", &makeExrs},
                                     {"image", &makeImages},
                                     {"point", &makePoints},
                                     {"options", &makeOptions}}) {
        fs::create_directories(root / name);
        make(root / name);
    }
    makeDictionary(root / "gltf.dict");
    return 0;
}
