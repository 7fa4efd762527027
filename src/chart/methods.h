// Which methods `sheen chart` sweeps, and over what. A new method is a line in methods.cpp.
#pragma once

#include <string>
#include <vector>

namespace sheen {

/// One point of a method's curve: a value for its option, and what rendering it costs, in seconds
/// for cornell_glossy at 512 x 512 on two cores; only ratios matter, to predict the time left.
struct SweepSetting {
    std::string value;
    double cost = 1;
};

/// Whether a method computes light of one bounce and of more, or is of interest there.
enum class SweptBounces { kAny, kOne, kMore };

struct SweepMethod {
    std::string name;                    ///< of `sheen chart --methods`
    std::string label;                   ///< in the report
    std::vector<std::string> arguments;  ///< of `sheen render`, at every setting
    std::string option;                  ///< of `sheen render`, what is swept
    std::vector<SweepSetting> settings;  ///< from the fastest on
    SweptBounces bounces = SweptBounces::kAny;

    bool has(int of_bounces) const {
        return bounces == SweptBounces::kAny ||
               (bounces == SweptBounces::kOne) == (of_bounces == 1);
    }
};

/// Of a path a pixel by the path tracer, as SweepSetting::cost.
constexpr double kPathCost = 0.1;

/// In the order of the report.
const std::vector<SweepMethod>& sweepMethods();

/// Those called `names`, in the report's order; for no name all that have so many bounces. Usage
/// error for a name that is none, or of a method that has not.
std::vector<SweepMethod> chooseMethods(const std::vector<std::string>& names, int bounces);

/// The command line's part that makes the setting: --method ... --option value
std::vector<std::string> settingArguments(const SweepMethod& method, const SweepSetting& setting);

/// The same for people: "accuracy 0.4".
std::string settingLabel(const SweepMethod& method, const SweepSetting& setting);

}  // namespace sheen
