#include "cli/view_options.h"

#include <fmt/format.h>

#include "core/error.h"

namespace sheen::cli {
namespace {

void addImageOptions(CLI::App& app, ViewOptions& o) {
    addSceneOption(app, o.scene);
    app.add_option("--size", o.size, "Width x height of the window, each 1..16384")
        ->capture_default_str();
    addViewpointOptions(app, o.params.camera, o.camera_at, o.look_at, o.fov);
    app.add_option("--variant", o.load.variant, "Materials by a name of KHR_materials_variants");
    addEnvironmentOptions(app, o.load.environment);
    app.add_option("--exposure", o.exposure, "Stops, or auto: the log-average becomes middle grey")
        ->capture_default_str();
    app.add_option("--tone", o.tone, "Tone curve: neutral or none")
        ->check(CLI::IsMember({"neutral", "none"}))
        ->capture_default_str();
}

void addQualityOptions(CLI::App& app, ViewOptions& o) {
    app.add_option("--method", o.method,
                   "radiance (glossy and diffuse) or irradiance (diffuse only)")
        ->check(CLI::IsMember({"radiance", "irradiance"}))
        ->capture_default_str();
    app.add_option("--accuracy", o.params.placement.accuracy,
                   "Largest error of a record's reuse, smaller is better and slower")
        ->check(numberIn(0.01, 2))
        ->capture_default_str();
    app.add_option("--sh-order", o.sh_order,
                   "Order of the spherical harmonics, 2..10, or auto: by material")
        ->capture_default_str();
    app.add_option("--gather-size", o.params.gather.size,
                   "Texels along a side of what a record sees; default: by the accuracy")
        ->check(numberIn(8, 512));
    app.add_option("--bounces", o.bounces,
                   "Bounces of indirect light: all, or so many at the most, 1..64")
        ->capture_default_str();
    app.add_option("--aa", o.params.aa,
                   "Samples of a pixel through which an edge passes, of the complete image")
        ->check(CLI::IsMember({1, 2, 4, 8, 16, 32, 64}))
        ->type_name("N")
        ->capture_default_str();
}

void addScriptOptions(CLI::App& app, ViewOptions& o) {
    app.add_option("--screenshot", o.screenshot,
                   "PNG file of the complete image, after which the window closes")
        ->type_name("FILE")
        ->check(fileName());
    app.add_option("--frames", o.frames, "With --screenshot: after so many steps instead")
        ->check(numberIn(1, 1'000'000))
        ->needs("--screenshot");
    app.add_option("--benchmark", o.benchmark,
                   "Waits for the complete image, flies a path of so many frames twice, and "
                   "closes; see --json")
        ->type_name("N")
        ->check(numberIn(1, 100'000))
        ->excludes("--screenshot");
    addThreadsOption(app, o.threads);
    addGlOption(app, o.gl);
    app.add_option("--json", o.json, "File for the benchmark's figures as JSON; -: standard output")
        ->type_name("FILE")
        ->check(fileName())
        ->needs("--benchmark");
}

}  // namespace

void addViewOptions(CLI::App& app, ViewOptions& o) {
    o.params.aa = kSmoothEdges;
    addImageOptions(app, o);
    addQualityOptions(app, o);
    addScriptOptions(app, o);
}

void understand(ViewOptions& o) {
    const ivec2 size = parseSize(o.size);
    o.params.width = size.x;
    o.params.height = size.y;
    o.params.method = o.method == "radiance" ? Method::kRadiance : Method::kIrradiance;
    o.params.sh_order = parseShOrder(o.sh_order);
    o.params.bounces = parseBounces(o.bounces);
    o.params.gl = parseGl(o.gl);
    parseExposure(o.exposure);
    parseViewpoint(o.camera_at, o.look_at, o.fov, o.params.camera, o.load);
    if (!o.screenshot.empty() && imageKind(o.screenshot) != FileKind::kPng) {
        throwUsage("--screenshot {}: a PNG file is written; end the name in .png", o.screenshot);
    }
}

}  // namespace sheen::cli
