#include <algorithm>
#include <cmath>
#include <filesystem>

#include "chart/chart.h"
#include "image/exr.h"
#include "image/png.h"

namespace sheen {
namespace {

const char* const kLayer = "indirect";
const char* const kVarianceLayer = "variance";

struct Means {
    double value = 0;
    double variance = 0;
};

// Over the samples that see geometry.
Means meansOf(const LoadedExr& reference) {
    const Image<vec3>& image = colorLayer(reference, kLayer);
    const Image<vec3>& variance = colorLayer(reference, kVarianceLayer);
    Means means;
    int64_t samples = 0;
    for (size_t i = 0; i < image.pixels.size(); ++i) {
        if (!reference.primitive.empty() && reference.primitive.pixels[i] == kNoPrimitive) {
            continue;
        }
        for (int c = 0; c < 3; ++c) {
            means.value += image.pixels[i][c];
            means.variance += variance.pixels[i][c];
            ++samples;
        }
    }
    const double count = static_cast<double>(std::max<int64_t>(samples, 1));
    return {means.value / count, means.variance / count};
}

}  // namespace

void judgeScene(const std::string& folder, ChartScene& scene) {
    const std::filesystem::path root = folder;
    const LoadedExr reference = readExr((root / scene.reference_file).string());
    const Means means = meansOf(reference);
    if (!(means.value > 0)) {
        throwInput(
            "{}: camera '{}' sees no indirect light, so that no error can be measured: give the "
            "scene a light, or choose another --camera",
            scene.file, scene.camera);
    }
    scene.noise_rel_rmse = std::sqrt(means.variance) / means.value;
    const Image<vec3>& truth = colorLayer(reference, kLayer);
    const float exposure = autoExposure(truth);
    scene.reference_png = pngBytes(displayImage(truth, exposure));
    for (ChartPoint& point : scene.points) {
        const LoadedExr image = readExr((root / point.file).string());
        const CompareInput input = {.test = colorLayer(image, kLayer),
                                    .reference = truth,
                                    .reference_variance = &colorLayer(reference, kVarianceLayer),
                                    .test_primitive = &image.primitive,
                                    .reference_primitive = &reference.primitive,
                                    .test_name = image.path,
                                    .reference_name = reference.path};
        point.errors = compareImages(input);
        point.image_png = pngBytes(displayImage(input.test, exposure));
        point.heatmap_png = pngBytes(bytesFromDisplay(heatmap(input)));
    }
}

std::vector<size_t> paretoFront(std::span<const TimeAndError> points) {
    std::vector<size_t> order;
    for (size_t i = 0; i < points.size(); ++i) {
        const auto positive = [](double x) { return std::isfinite(x) && x > 0; };
        if (positive(points[i].seconds) && positive(points[i].error)) {
            order.push_back(i);
        }
    }
    std::stable_sort(order.begin(), order.end(), [&points](size_t a, size_t b) {
        return std::pair(points[a].seconds, points[a].error) <
               std::pair(points[b].seconds, points[b].error);
    });
    std::vector<size_t> front;
    for (const size_t i : order) {
        const bool better = front.empty() || points[i].error < points[front.back()].error;
        const bool equal = !front.empty() && points[i].error == points[front.back()].error &&
                           points[i].seconds == points[front.back()].seconds;
        if (better || equal) {
            front.push_back(i);
        }
    }
    return front;
}

}  // namespace sheen
