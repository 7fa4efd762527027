// Random scenes by the cache and by the reference.
#include <fmt/format.h>

#include <cmath>
#include <filesystem>

#include "image/png.h"
#include "judge.h"
#include "metrics/compare.h"
#include "reference/reference.h"
#include "render/render.h"
#include "stress_flags.h"
#include "stress_scenes.h"

namespace sheen::bench {
namespace {

// Of a flagged scene: how many more paths its next reference has.
constexpr int kNextOpinion = 4;

void paste(Image<Rgb8>& sheet, const Image<Rgb8>& tile, int column, int row, int zoom) {
    for (int y = 0; y < zoom * tile.height; ++y) {
        for (int x = 0; x < zoom * tile.width; ++x) {
            sheet.at(column * (zoom * tile.width + 4) + x, row * (zoom * tile.height + 4) + y) =
                tile.at(x / zoom, y / zoom);
        }
    }
}

// Six pictures: beauty and indirect layer by the cache, by the reference; errors, and flags (red:
// indirect, blue: direct, dark green: tile, grey: another triangle).
void keepImages(const std::string& path, const Frame& test, const Frame& truth,
                const Flags& flags) {
    constexpr int kZoom = 4;
    const int size = truth.width();
    Image<Rgb8> sheet(3 * kZoom * size + 8, 2 * kZoom * size + 4, Rgb8{128, 128, 128});
    const float beauty_exposure = autoExposure(beauty(truth));
    const float exposure = autoExposure(truth.indirect);
    paste(sheet, displayImage(beauty(test), beauty_exposure), 0, 0, kZoom);
    paste(sheet, displayImage(beauty(truth), beauty_exposure), 0, 1, kZoom);
    paste(sheet, displayImage(test.indirect, exposure), 1, 0, kZoom);
    paste(sheet, displayImage(truth.indirect, exposure), 1, 1, kZoom);
    const CompareInput input = {.test = test.indirect,
                                .reference = truth.indirect,
                                .reference_variance = &truth.indirect_variance,
                                .test_primitive = &test.primitive,
                                .reference_primitive = &truth.primitive};
    paste(sheet, bytesFromDisplay(heatmap(input)), 2, 0, kZoom);
    Image<vec3> marks(size, size);
    for (size_t i = 0; i < marks.pixels.size(); ++i) {
        const uint8_t m = flags.mask.pixels[i];
        marks.pixels[i] = (m & 8) != 0
                              ? vec3(0.5f)
                              : vec3((m & 1) != 0, (m & 4) != 0 ? 0.3f : 0.0f, (m & 2) != 0);
    }
    paste(sheet, bytesFromDisplay(marks), 2, 1, kZoom);
    writePng(path, sheet);
}

// Roughness of the smoothest material that has a lobe; 1 where none has. What lights send off
// smooth ones the reference finds too rarely to judge.
float smoothest(const Scene& scene) {
    float roughness = 1.0f;
    for (const Material& material : scene.materials) {
        const MaterialParams& m = material.params;
        if (m.metallic > 0.0f || m.specular > 0.0f) {
            roughness = std::min(roughness, m.roughness);
        }
    }
    return roughness;
}

// By what factor the error lies outside the interval that was printed: 1 where it lies in it; NaN
// where either is not known.
double outside(const Flags& flags, const RenderStats& stats) {
    if (!flags.known || !(stats.estimate_high > 0.0)) {
        return std::numeric_limits<double>::quiet_NaN();
    }
    return std::max({1.0, flags.rel_rmse / stats.estimate_high,
                     stats.estimate_low / std::max(flags.rel_rmse, 1e-9)});
}

struct Found {
    bool flagged = false, patches = false;
    double outside = 1;
};

Found stressOne(uint32_t seed, const StressOptions& options) {
    const StressScene made = stressScene(seed);
    const Scene& scene = made.scene;
    RenderParams params;
    params.width = params.height = options.size;
    params.quiet = true;
    params.bounces = 1;
    const RenderResult result = renderFrame(scene, params);
    const auto reference = [&](int spp) {
        return renderReference(scene, {.width = options.size,
                                       .height = options.size,
                                       .camera = scene.cameras.front(),
                                       .bounces = 1,
                                       .spp = spp,
                                       .quiet = true});
    };
    ReferenceResult truth = reference(options.spp);
    Flags flags = flagErrors(result.frame, truth.frame, {});
    // The reference's noise has a long tail: ask again before blaming the cache.
    int spp = kNextOpinion * options.spp;
    for (bool flagged = flags.pixels + flags.tiles > 0;
         spp <= options.most && (flagged || !flags.known); flagged = false, spp *= kNextOpinion) {
        truth = reference(spp);
        flags = flagErrors(result.frame, truth.frame, {});
    }
    const int others = result.stats.nonfinite_pixels + result.stats.pixels_uncovered +
                       static_cast<int>(truth.nonfinite_samples) + flags.nonfinite;
    const Found found = {.flagged = flags.pixels + flags.tiles + flags.direct + others > 0,
                         .patches = flags.patches > 0,
                         .outside = outside(flags, result.stats)};
    fmt::print(
        "{:4d} {} rel_rmse {:6.2f}% bias {:+6.2f}% noise {:.2f} | pixels {:4d} in patches {:3d} "
        "worst {:5.2f} at "
        "{:2d},{:2d} | tiles {:2d} worst {:5.2f} at {:2d},{:2d} | direct {:4d} worst {:5.2f} at "
        "{:2d},{:2d} | not finite or uncovered {} other triangle {} of {} | records {} gloss "
        "{:.2f} smoothest {:.2f} | estimate {:.2f} to {:.2f}% outside {:.2f} | {}\n",
        seed, found.flagged ? "FLAG" : "ok  ", 100 * flags.rel_rmse, 100 * flags.bias,
        flags.noise_share, flags.pixels, flags.patches, flags.pixel.excess, flags.pixel.at.x,
        flags.pixel.at.y, flags.tiles, flags.tile.excess, flags.tile.at.x, flags.tile.at.y,
        flags.direct, flags.direct_pixel.excess, flags.direct_pixel.at.x, flags.direct_pixel.at.y,
        others, flags.other_triangle, flags.geometry, result.stats.records,
        result.stats.too_glossy_share, smoothest(scene), 100 * result.stats.estimate_low,
        100 * result.stats.estimate_high, found.outside, made.what);
    std::fflush(stdout);
    if (!options.keep.empty() && (found.flagged || options.keep_all) && flags.nonfinite == 0) {
        keepImages(fmt::format("{}/{:04d}.png", options.keep, seed), result.frame, truth.frame,
                   flags);
    }
    return found;
}

}  // namespace

bool stress(const StressOptions& options) {
    if (!options.keep.empty()) {
        std::filesystem::create_directories(options.keep);
    }
    int flagged = 0, patches = 0, failed = 0, known = 0, within = 0;
    double farthest = 1.0;
    for (uint32_t seed = options.first; seed <= options.last; ++seed) {
        try {
            const Found found = stressOne(seed, options);
            flagged += found.flagged ? 1 : 0;
            patches += found.patches ? 1 : 0;
            if (!std::isnan(found.outside)) {
                ++known;
                within += found.outside == 1.0 ? 1 : 0;
                farthest = std::max(farthest, found.outside);
            }
        } catch (const std::exception& error) {
            ++failed;
            fmt::print("{:4d} FAIL {}\n", seed, error.what());
        }
    }
    fmt::print(
        "{} seeds, {} flagged, {} with patches, {} failed; of {} errors that are known {} lie in "
        "the "
        "interval of their estimate, the others by up to {:.2f} times outside\n",
        options.last - options.first + 1, flagged, patches, failed, known, within, farthest);
    return flagged + failed == 0;
}

}  // namespace sheen::bench
