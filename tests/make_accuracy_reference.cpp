// Makes what tests/accuracy_test.cpp judges by small enough to keep; tests/references/make calls
// it.
//   make_accuracy_reference scenes FOLDER     writes the case scenes as FOLDER/NAME.glb
//   make_accuracy_reference strip IN OUT      of IN, an EXR file of `--method reference`, keeps in
//                                             OUT the indirect layer (half), the triangles seen and
//                                             the variance, each tile's mean in all of its pixels
#include <OpenEXR/ImfChannelList.h>
#include <OpenEXR/ImfFrameBuffer.h>
#include <OpenEXR/ImfHeader.h>
#include <OpenEXR/ImfOutputFile.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <filesystem>

#include "case_scenes.h"
#include "image/exr.h"

namespace sheen {
namespace {

// Figures of an image and of its tiles only take sums of variances; the noise of single pixels'
// variances would be most of the file.
constexpr int kTileSize = 16;

Image<vec3> tileMeans(const Image<vec3>& image) {
    Image<vec3> means(image.width, image.height);
    for (int y = 0; y < image.height; ++y) {
        for (int x = 0; x < image.width; ++x) {
            const ivec2 lower(x / kTileSize * kTileSize, y / kTileSize * kTileSize);
            const ivec2 upper(std::min(lower.x + kTileSize, image.width),
                              std::min(lower.y + kTileSize, image.height));
            glm::dvec3 sum(0.0);
            for (int ty = lower.y; ty < upper.y; ++ty) {
                for (int tx = lower.x; tx < upper.x; ++tx) {
                    sum += image.at(tx, ty);
                }
            }
            means.at(x, y) = sum / static_cast<double>((upper.x - lower.x) * (upper.y - lower.y));
        }
    }
    return means;
}

void strip(const std::string& in, const std::string& out) {
    const LoadedExr exr = readExr(in);
    const Image<vec3>& indirect = colorLayer(exr, "indirect");
    const Image<vec3> variance = tileMeans(colorLayer(exr, "variance"));
    if (exr.primitive.empty()) {
        throwInput("{}: no layer of triangles", in);
    }
    const auto width = static_cast<size_t>(exr.width);
    Imf::Header header(exr.width, exr.height);
    header.compression() = Imf::ZIP_COMPRESSION;
    Imf::FrameBuffer pixels;
    const auto insert = [&](const std::string& name, Imf::PixelType type, const void* data,
                            size_t stride) {
        header.channels().insert(name, Imf::Channel(type));
        // A slice serves reading and writing alike, hence the cast.
        char* base = static_cast<char*>(const_cast<void*>(data));
        pixels.insert(name, Imf::Slice(type, base, stride, stride * width));
    };
    std::array<std::vector<half>, 3> halves;
    for (int c = 0; c < 3; ++c) {
        const std::string channel(1, "RGB"[c]);
        for (const vec3& pixel : indirect.pixels) {
            halves[static_cast<size_t>(c)].push_back(half(pixel[c]));
        }
        insert("indirect." + channel, Imf::HALF, halves[static_cast<size_t>(c)].data(),
               sizeof(half));
        insert("variance." + channel, Imf::FLOAT, &variance.pixels[0][c], sizeof(vec3));
    }
    insert("primitive.id", Imf::UINT, exr.primitive.pixels.data(), sizeof(uint32_t));
    Imf::OutputFile file(out.c_str(), header);
    file.setFrameBuffer(pixels);
    file.writePixels(exr.height);
}

int run(const std::vector<std::string>& arguments) {
    if (arguments.size() == 2 && arguments[0] == "scenes") {
        for (const CaseScene& scene : caseScenes()) {
            writeScene(scene.model, std::filesystem::path(arguments[1]) / (scene.name + ".glb"));
        }
    } else if (arguments.size() == 3 && arguments[0] == "strip") {
        strip(arguments[1], arguments[2]);
    } else {
        std::fprintf(stderr, "usage: make_accuracy_reference scenes FOLDER | strip IN OUT\n");
        return 2;
    }
    return 0;
}

}  // namespace
}  // namespace sheen

int main(int argc, char** argv) {
    try {
        return sheen::run({argv + 1, argv + argc});
    } catch (const sheen::Error& error) {
        std::fprintf(stderr, "make_accuracy_reference: %s\n", error.what());
        return static_cast<int>(error.code());
    } catch (const std::exception& error) {
        std::fprintf(stderr, "make_accuracy_reference: %s\n", error.what());
        return static_cast<int>(sheen::ExitCode::kEnvironment);
    }
}
