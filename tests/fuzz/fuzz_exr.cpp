// readExr() on any bytes, and what `sheen compare` does with the layers it finds.
#include <OpenEXR/ImfHeader.h>

#include <cmath>

#include "core/parallel.h"
#include "fuzz/fuzz.h"
#include "image/exr.h"
#include "metrics/compare.h"

namespace sheen::fuzz {
namespace {

template <class T>
void checkSize(const LoadedExr& exr, const Image<T>& image) {
    require(
        image.width == exr.width && image.height == exr.height &&
            image.pixels.size() == static_cast<size_t>(exr.width) * static_cast<size_t>(exr.height),
        "every layer has the file's size");
}

// Against itself and against a layer of ones: figures, or an input error on odd pixels.
void checkComparable(const LoadedExr& exr, const Image<vec3>& layer) {
    constexpr int kMostPixels = 4096;  // the sums over larger images only take time
    if (layer.count() > kMostPixels) {
        return;
    }
    const Image<vec3> ones(exr.width, exr.height, vec3(1.0f));
    for (const Image<vec3>* test : {&layer, &ones}) {
        const CompareInput input = {.test = *test, .reference = layer};
        try {
            const Comparison c = compareImages(input);
            require(test != &layer || c.rel_rmse == 0.0, "an image equals itself");
            for (const double figure : {c.rel_rmse, c.rel_mse, c.bias, c.median, c.p99, c.max,
                                        c.tile_max, c.noise_share}) {
                require(!std::isnan(figure), "figures are numbers");
            }
            heatmap(input);
        } catch (const Error& error) {
            require(error.code() == ExitCode::kInput, "bad input has exit code 3", error.what());
            requireOneLine(error.what());
        }
    }
}

}  // namespace
}  // namespace sheen::fuzz

extern "C" int LLVMFuzzerInitialize(int*, char***) {
    // Otherwise most of the time goes into clearing the memory of large images and tiles.
    constexpr int kLargestSide = 512;
    Imf::Header::setMaxImageSize(kLargestSide, kLargestSide);
    Imf::Header::setMaxTileSize(kLargestSide, kLargestSide);
    sheen::setThreadCount(1);
    return 0;
}

extern "C" int LLVMFuzzerTestOneInput(const uint8_t* data, size_t size) {
    using namespace sheen;
    static const fuzz::InputFile file("image.exr");
    const std::string& path = file.write(data, size);
    try {
        const LoadedExr exr = readExr(path);
        fuzz::require(exr.width > 0 && exr.height > 0, "an image has pixels");
        for (const auto& [name, image] : exr.colors) {
            fuzz::checkSize(exr, image);
            fuzz::checkComparable(exr, image);
        }
        for (const auto& [name, image] : exr.scalars) {
            fuzz::checkSize(exr, image);
        }
        if (!exr.primitive.empty()) {
            fuzz::checkSize(exr, exr.primitive);
        }
        colorLayer(exr, "no such layer");
    } catch (const Error& error) {
        fuzz::requireInputError(error, path);
    }
    return 0;
}
