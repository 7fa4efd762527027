// sweep SCENE REFERENCE.exr [KEY=VALUE ...]: renders a scene with some of the parameters changed
// that the program has no option for, and prints one line: cost, and error of the indirect layer.
// What docs/decisions.md reports is measured with it.
#include <fmt/format.h>
#include <sys/resource.h>

#include <charconv>
#include <functional>
#include <map>

#include "core/error.h"
#include "core/parallel.h"
#include "core/timer.h"
#include "image/exr.h"
#include "metrics/compare.h"
#include "render/render.h"

namespace {

using namespace sheen;

using Setter = std::function<void(RenderParams&, float)>;
const std::map<std::string, Setter> kSetters = {
    {"accuracy", [](RenderParams& p, float v) { p.placement.accuracy = v; }},
    {"normal_weight", [](RenderParams& p, float v) { p.placement.normal_weight = v; }},
    {"slab", [](RenderParams& p, float v) { p.placement.slab = v; }},
    {"min_pixels", [](RenderParams& p, float v) { p.placement.min_pixels = v; }},
    {"split_sphere",
     [](RenderParams& p, float v) {
         p.placement.control = v > 0 ? ErrorControl::kSplitSphere : ErrorControl::kHessian;
     }},
    {"curvature", [](RenderParams& p, float v) { p.placement.curvature = v; }},
    {"overlap", [](RenderParams& p, float v) { p.placement.overlap = v; }},
    {"max_pixels", [](RenderParams& p, float v) { p.placement.max_pixels = v; }},
    {"clamping", [](RenderParams& p, float v) { p.placement.neighbour_clamping = v > 0; }},
    {"disagreement", [](RenderParams& p, float v) { p.placement.disagreement = v; }},
    {"gradient_limit", [](RenderParams& p, float v) { p.placement.gradient_limit = v; }},
    {"batch", [](RenderParams& p, float v) { p.placement.batch = static_cast<int>(v); }},
    {"stride", [](RenderParams& p, float v) { p.placement.coarsest_stride = static_cast<int>(v); }},
    {"sh_order", [](RenderParams& p, float v) { p.sh_order = static_cast<int>(v); }},
    {"target_error", [](RenderParams& p, float v) { p.target_error = v; }},
    {"size", [](RenderParams& p, float v) { p.gather.size = static_cast<int>(v); }},
    {"extent", [](RenderParams& p, float v) { p.gather.extent = v; }},
    {"hemisphere",  // in the order of HemisphereKind
     [](RenderParams& p, float v) {
         p.gather.kind = static_cast<HemisphereKind>(static_cast<int>(v));
     }},
    {"raster", [](RenderParams& p,
                  float v) { p.gather_road = v > 0 ? GatherRoad::kRaster : GatherRoad::kRays; }},
    {"threads", [](RenderParams&, float v) { setThreadCount(static_cast<int>(v)); }},
};

void set(RenderParams& params, const std::string& argument) {
    const size_t equals = argument.find('=');
    const auto setter = kSetters.find(argument.substr(0, equals));
    float value = 0.0f;
    const char* end = argument.data() + argument.size();
    if (setter == kSetters.end() || equals == std::string::npos ||
        std::from_chars(argument.data() + equals + 1, end, value).ptr != end) {
        std::string keys;
        for (const auto& [key, unused] : kSetters) {
            keys += " " + key;
        }
        throwUsage("{}: not KEY=NUMBER with one of the keys{}", argument, keys);
    }
    setter->second(params, value);
}

double cpuSeconds() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    const auto seconds = [](const timeval& t) {
        return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
    };
    return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

void sweep(const std::vector<std::string>& arguments) {
    const Scene scene = loadScene(arguments[0]);
    const LoadedExr reference = readExr(arguments[1]);
    const Image<vec3>& truth = colorLayer(reference, "indirect");
    RenderParams params;
    params.width = truth.width;
    params.height = truth.height;
    params.quiet = true;
    for (size_t i = 2; i < arguments.size(); ++i) {
        set(params, arguments[i]);
    }
    const Timer timer;
    const double cpu_before = cpuSeconds();
    const RenderResult result = renderFrame(scene, params);
    const double wall = timer.seconds();
    const double cpu = cpuSeconds() - cpu_before;
    const auto variance = reference.colors.find("variance");
    const Comparison c = compareImages(
        {.test = result.frame.indirect,
         .reference = truth,
         .reference_variance = variance == reference.colors.end() ? nullptr : &variance->second,
         .test_primitive = &result.frame.primitive,
         .reference_primitive = &reference.primitive});
    fmt::print(
        "records {:6d}  cpu {:6.2f} s  wall {:6.2f} s  gather {:6.2f} s | rel_rmse {:.2f}%  bias "
        "{:+.2f}%  median {:.2f}%  p99 {:.1f}%  tile_max {:.1f}%  noise_share {:.2f}  est "
        "{:.2f}%\n",
        result.stats.records, cpu, wall, result.stats.seconds.gather, 100 * c.rel_rmse,
        100 * c.bias, 100 * c.median, 100 * c.p99, 100 * c.tile_max, c.noise_share,
        100 * result.stats.estimated_rel_rmse);
}

}  // namespace

int main(int argc, char** argv) {
    try {
        if (argc < 3) {
            throwUsage("usage: sweep SCENE REFERENCE.exr [KEY=VALUE ...]");
        }
        sweep({argv + 1, argv + argc});
        return 0;
    } catch (const std::exception& error) {
        fmt::print(stderr, "sweep: {}\n", error.what());
        return 2;
    }
}
