#include "chart/methods.h"

#include <algorithm>

#include "core/error.h"

namespace sheen {

const std::vector<SweepMethod>& sweepMethods() {
    // Finer reuse without more texels a record leaves the texels' own noise, and the reverse: the
    // pairs grow together. 0.5 and 34 are the program's defaults.
    static const std::vector<SweepSetting> kAccuracies = {
        {{"1.5", "24"}, 0.9}, {{"1", "28"}, 1.5},  {{"0.7", "34"}, 2.4},
        {{"0.5", "34"}, 3.2}, {{"0.35", "40"}, 6}, {{"0.25", "48"}, 13}};
    static const std::vector<SweepMethod> kMethods = {
        {"radiance", "radiance cache", {"--accuracy", "--gather-size"}, kAccuracies},
        {"irradiance", "irradiance cache", {"--accuracy", "--gather-size"}, kAccuracies},
        {"reference", "path tracer", {"--spp"}, {{{"16"}, 2}, {{"64"}, 8}, {{"256"}, 30}}},
    };
    return kMethods;
}

std::vector<SweepMethod> chooseMethods(const std::vector<std::string>& names) {
    std::string known;
    for (const SweepMethod& method : sweepMethods()) {
        known += (known.empty() ? "" : ", ") + method.name;
    }
    const auto named = [&names](const SweepMethod& method) {
        return names.empty() || std::find(names.begin(), names.end(), method.name) != names.end();
    };
    for (const std::string& name : names) {
        const auto is_name = [&name](const SweepMethod& method) { return method.name == name; };
        if (std::none_of(sweepMethods().begin(), sweepMethods().end(), is_name)) {
            throwUsage("--methods {}: no such method; there are: {}", name, known);
        }
    }
    std::vector<SweepMethod> chosen;
    std::copy_if(sweepMethods().begin(), sweepMethods().end(), std::back_inserter(chosen), named);
    return chosen;
}

std::vector<std::string> settingArguments(const SweepMethod& method, const SweepSetting& setting) {
    SHEEN_CHECK_EQ(method.options.size(), setting.values.size());
    std::vector<std::string> arguments = {"--method", method.name};
    for (size_t i = 0; i < method.options.size(); ++i) {
        arguments.push_back(method.options[i]);
        arguments.push_back(setting.values[i]);
    }
    return arguments;
}

std::string settingLabel(const SweepMethod& method, const SweepSetting& setting) {
    std::string label;
    for (size_t i = 0; i < method.options.size(); ++i) {
        label += (i == 0 ? "" : ", ") + method.options[i].substr(2) + " " + setting.values[i];
    }
    return label;
}

}  // namespace sheen
