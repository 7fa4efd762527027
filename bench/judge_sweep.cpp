// One render with parameters that are no options of the program.
#include <fmt/format.h>
#include <sys/resource.h>

#include <charconv>
#include <cmath>
#include <functional>
#include <map>
#include <optional>

#include "core/error.h"
#include "core/parallel.h"
#include "core/timer.h"
#include "image/exr.h"
#include "judge.h"
#include "metrics/compare.h"
#include "render/render.h"

namespace sheen::bench {
namespace {

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
    {"kmeans", [](RenderParams& p,
                  float v) { p.placement.sites = v > 0 ? SitesBy::kKMeans : SitesBy::kScan; }},
    {"bounces",
     [](RenderParams& p, float v) { p.bounces = v > 0 ? static_cast<int>(v) : kAllBounces; }},
    {"photons",
     [](RenderParams& p, float v) {
         p.kept_by = v > 0 ? KeptBy::kPhotons : KeptBy::kElements;
         p.photons = static_cast<int>(v);
     }},
    {"clusters", [](RenderParams& p, float v) { p.placement.clusters = static_cast<int>(v); }},
    {"harmonic",
     [](RenderParams& p, float v) {
         p.placement.control = v > 0 ? ErrorControl::kHarmonic : ErrorControl::kHessian;
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
    {"aa", [](RenderParams& p, float v) { p.aa = static_cast<int>(v); }},
    {"target_error", [](RenderParams& p, float v) { p.target_error = v; }},
    {"size", [](RenderParams& p, float v) { p.gather.size = static_cast<int>(v); }},
    {"extent", [](RenderParams& p, float v) { p.gather.extent = v; }},
    {"hemisphere",  // in the order of HemisphereKind
     [](RenderParams& p, float v) {
         p.gather.kind = static_cast<HemisphereKind>(static_cast<int>(v));
     }},
    {"raster", [](RenderParams& p,
                  float v) { p.gather_road = v > 0 ? GatherRoad::kRaster : GatherRoad::kRays; }},
    {"rays_per_alpha", [](RenderParams& p, float v) { p.specular.rays_per_alpha = v; }},
    {"max_rays", [](RenderParams& p, float v) { p.specular.max_rays = static_cast<int>(v); }},
    {"window", [](RenderParams& p, float v) { p.specular.window = v; }},
    {"threads", [](RenderParams&, float v) { setThreadCount(static_cast<int>(v)); }},
};

struct Setting {
    Setter set;
    float value = 0.0f;
    int records = 0;  // not 0: the value is to be searched that takes so many
};

Setting parseSetting(const std::string& argument) {
    const size_t equals = argument.find('=');
    const auto setter = kSetters.find(argument.substr(0, equals));
    Setting setting;
    const char* end = argument.data() + argument.size();
    const bool search = equals != std::string::npos && argument[equals + 1] == '@';
    const char* first = argument.data() + equals + (search ? 2 : 1);
    if (setter == kSetters.end() || equals == std::string::npos ||
        (search ? std::from_chars(first, end, setting.records).ptr
                : std::from_chars(first, end, setting.value).ptr) != end ||
        (search && setting.records <= 0)) {
        std::string keys;
        for (const auto& [key, unused] : kSetters) {
            keys += " " + key;
        }
        throwUsage("{}: not KEY=NUMBER or KEY=@RECORDS with one of the keys{}", argument, keys);
    }
    setting.set = setter->second;
    return setting;
}

// Sets the value that takes about the setting's records, the more of them the smaller it is: by
// doubling, then by interpolating logarithms. The nearest it finds, if none is near.
void search(const Scene& scene, const Setting& setting, RenderParams& params) {
    constexpr int kTries = 12;
    constexpr double kNear = 0.03;
    struct Tried {
        double value, records;
    };
    std::optional<Tried> few, many;  // the nearest on either side
    double value = 1.0;
    for (int i = 0; i < kTries; ++i) {
        setting.set(params, static_cast<float>(value));
        const double records = std::max(renderFrame(scene, params).stats.records, 1);
        if (std::abs(records / setting.records - 1.0) < kNear) {
            return;
        }
        (records < setting.records ? few : many) = Tried{value, records};
        if (few && many && few->records != many->records) {
            const double share =
                std::log(setting.records / few->records) / std::log(many->records / few->records);
            value = few->value * std::pow(many->value / few->value, glm::clamp(share, 0.1, 0.9));
        } else {
            value = few ? 0.5 * few->value : 2.0 * many->value;
        }
    }
}

double cpuSeconds() {
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    const auto seconds = [](const timeval& t) {
        return static_cast<double>(t.tv_sec) + 1e-6 * static_cast<double>(t.tv_usec);
    };
    return seconds(usage.ru_utime) + seconds(usage.ru_stime);
}

}  // namespace

void sweep(const std::string& scene_file, const std::string& reference_file,
           const std::vector<std::string>& settings) {
    const Scene scene = loadScene(scene_file);
    const LoadedExr reference = readExr(reference_file);
    const Image<vec3>& truth = colorLayer(reference, "indirect");
    RenderParams params;
    params.width = truth.width;
    params.height = truth.height;
    params.quiet = true;
    params.bounces = 1;
    params.caustics = 0;
    std::optional<Setting> searched;
    for (const std::string& argument : settings) {
        const Setting setting = parseSetting(argument);
        if (setting.records > 0) {
            searched = setting;
        } else {
            setting.set(params, setting.value);
        }
    }
    if (searched) {
        search(scene, *searched, params);
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
        "{:.2f}% ({:.2f} to {:.2f}%)\n",
        result.stats.records, cpu, wall, result.stats.seconds.gather, 100 * c.rel_rmse,
        100 * c.bias, 100 * c.median, 100 * c.p99, 100 * c.tile_max, c.noise_share,
        100 * result.stats.estimated_rel_rmse, 100 * result.stats.estimate_low,
        100 * result.stats.estimate_high);
}

}  // namespace sheen::bench
