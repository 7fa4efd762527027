#include "cli/compare_pair.h"

#include <vector>

#include "core/memory.h"

namespace sheen::cli {
namespace {

bool hasCaustics(const LoadedExr& exr) { return exr.colors.count("caustic") > 0; }

// The variances that add up to that of `layer`: emission has none, direct and indirect light are
// sampled independently. The paths of caustics are those of indirect light.
std::vector<std::string> varianceLayers(const LoadedExr& exr, const std::string& layer) {
    const std::string global = hasCaustics(exr) ? "variance_global" : "variance";
    if (layer == "indirect") {
        return {"variance"};
    }
    if (layer == "indirect_diffuse") {
        return {"variance_diffuse"};
    }
    if (layer == "direct") {
        return {"variance_direct"};
    }
    if (layer == "caustic") {
        return {"variance_caustic"};
    }
    if (layer == kGlobal) {
        return {global};
    }
    return {global, "variance_direct"};
}

// Empty where the file does not know it.
Image<vec3> varianceOf(const LoadedExr& exr, const std::string& layer) {
    Image<vec3> sum;
    for (const std::string& name : varianceLayers(exr, layer)) {
        const auto found = exr.colors.find(name);
        if (found == exr.colors.end()) {
            return {};
        }
        if (sum.empty()) {
            sum = found->second;
            continue;
        }
        for (size_t i = 0; i < sum.pixels.size(); ++i) {
            sum.pixels[i] += found->second.pixels[i];
        }
    }
    return sum;
}

Image<vec3> layerOf(const LoadedExr& exr, const std::string& layer) {
    if (layer != kGlobal) {
        return colorLayer(exr, layer);
    }
    Image<vec3> sum = colorLayer(exr, "indirect");
    if (hasCaustics(exr)) {
        const Image<vec3>& caustic = colorLayer(exr, "caustic");
        for (size_t i = 0; i < sum.pixels.size(); ++i) {
            sum.pixels[i] += caustic.pixels[i];
        }
    }
    return sum;
}

// Where only one of the files has caustics apart, its indirect layers hold other light.
void checkAlike(const LoadedExr& test, const LoadedExr& reference, const std::string& layer) {
    const bool indirect = layer == "indirect" || layer == "indirect_diffuse";
    if (indirect && hasCaustics(test) != hasCaustics(reference)) {
        throwInput(
            "{}: its indirect light holds caustics, that of {} does not: compare --layer {}, or "
            "render both with the same --caustics",
            hasCaustics(test) ? reference.path : test.path,
            hasCaustics(test) ? test.path : reference.path, kGlobal);
    }
}

}  // namespace

ComparedPair::ComparedPair(const std::string& test_path, const std::string& reference_path,
                           const std::string& layer)
    : test(readExr(test_path)), reference(readExr(reference_path)) {
    constexpr uint64_t kBytesPerPixel = 128;  // sums, errors in order, the heat map, its file
    checkMemory({.bytes = kBytesPerPixel * static_cast<uint64_t>(reference.width) *
                          static_cast<uint64_t>(reference.height)},
                fmt::format("comparing with {}", reference_path), "use smaller images");
    checkAlike(test, reference, layer);
    of_test = layerOf(test, layer);
    of_reference = layerOf(reference, layer);
    variance = varianceOf(reference, layer);
}

CompareInput ComparedPair::input() const {
    return {.test = of_test,
            .reference = of_reference,
            .reference_variance = variance.empty() ? nullptr : &variance,
            .test_primitive = test.primitive.empty() ? nullptr : &test.primitive,
            .reference_primitive = reference.primitive.empty() ? nullptr : &reference.primitive,
            .test_name = test.path,
            .reference_name = reference.path};
}

void checkJudged(const Comparison& comparison, const std::string& test,
                 const std::string& reference) {
    if (comparison.compared == 0) {
        throwInput("{}: not judged: no pixel shows the same triangle as in {}", test, reference);
    }
    if (!comparison.judged) {
        throwInput(
            "{}: not judged: {:.0f}% of the difference is the reference's own noise; render {} "
            "with more --spp",
            test, 100.0 * comparison.noise_share, reference);
    }
}

Json comparisonJson(const Comparison& c) {
    return {{"rel_rmse", c.rel_rmse},
            {"rel_mse", c.rel_mse},
            {"bias", c.bias},
            {"median", c.median},
            {"p99", c.p99},
            {"max", c.max},
            {"noise_median", c.noise_median},
            {"noise_p99", c.noise_p99},
            {"tile_max", c.tile_max},
            {"noise_share", c.noise_share},
            {"excluded", c.excluded}};
}

}  // namespace sheen::cli
