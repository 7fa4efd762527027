#include "chart/methods.h"

#include <algorithm>

#include "core/error.h"

namespace sheen {

const std::vector<SweepMethod>& sweepMethods() {
    // 0.4 is the program's default.
    static const std::vector<SweepSetting> kAccuracies = {
        {"2", 0.6}, {"1", 1}, {"0.6", 1.5}, {"0.4", 2.3}, {"0.25", 4.5}, {"0.12", 15}};
    static const std::vector<SweepSetting> kPaths = {
        {"16", 1.5}, {"64", 4}, {"256", 256 * kPathCost}, {"1024", 1024 * kPathCost}};
    static const std::vector<SweepMethod> kMethods = {
        {"radiance", "radiance cache", {"--method", "radiance"}, "--accuracy", kAccuracies},
        {"irradiance", "irradiance cache", {"--method", "irradiance"}, "--accuracy", kAccuracies},
        {"octree",
         "octree (Ward)",
         {"--method", "octree"},
         "--accuracy",
         {{"1.5", 0.7}, {"0.8", 1}, {"0.5", 2}, {"0.25", 8}},
         SweptBounces::kOne},
        {"hints",
         "radiance hints",
         {"--method", "hints"},
         "--hints",
         {{"512", 0.2}, {"4096", 0.5}, {"32768", 4}}},
        {"reference", "path tracer", {"--method", "reference"}, "--spp", kPaths},
        {"denoised", "path tracer, denoised", {"--method", "denoised"}, "--spp", kPaths},
        {"rasterised",
         "radiance cache, rasterised",
         {"--method", "radiance", "--gather", "hemicube"},
         "--accuracy",
         {{"2", 2}, {"1", 4}, {"0.4", 9}},
         SweptBounces::kOne},
        {"kmeans",
         "radiance cache, k-means",
         {"--method", "radiance", "--placement", "kmeans"},
         "--accuracy",
         {{"2", 0.6}, {"1", 1}, {"0.4", 2.3}}},
        {"photons",
         "radiance cache, photons",
         {"--method", "radiance", "--kept-by", "photons"},
         "--accuracy",
         {{"2", 0.8}, {"1", 1.2}, {"0.4", 2.5}},
         SweptBounces::kMore},
    };
    return kMethods;
}

std::vector<SweepMethod> chooseMethods(const std::vector<std::string>& names, int bounces) {
    std::string known;
    for (const SweepMethod& method : sweepMethods()) {
        known += (known.empty() ? "" : ", ") + method.name;
    }
    const auto named = [&](const SweepMethod& method) {
        return names.empty() ? method.has(bounces)
                             : std::find(names.begin(), names.end(), method.name) != names.end();
    };
    for (const std::string& name : names) {
        const auto is_name = [&name](const SweepMethod& method) { return method.name == name; };
        if (std::none_of(sweepMethods().begin(), sweepMethods().end(), is_name)) {
            throwUsage("--methods {}: no such method; there are: {}", name, known);
        }
    }
    std::vector<SweepMethod> chosen;
    std::copy_if(sweepMethods().begin(), sweepMethods().end(), std::back_inserter(chosen), named);
    for (const SweepMethod& method : chosen) {
        if (!method.has(bounces)) {
            throwUsage("--methods {}: {}", method.name,
                       bounces == 1 ? "is of light of more bounces; use --bounces all"
                                    : "computes one bounce; leave it out, or use --bounces 1");
        }
    }
    return chosen;
}

std::vector<std::string> settingArguments(const SweepMethod& method, const SweepSetting& setting) {
    std::vector<std::string> arguments = method.arguments;
    arguments.insert(arguments.end(), {method.option, setting.value});
    return arguments;
}

std::string settingLabel(const SweepMethod& method, const SweepSetting& setting) {
    return method.option.substr(2) + " " + setting.value;
}

}  // namespace sheen
