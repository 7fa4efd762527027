// accuracy SCENES OUTPUT [--records N] [STUDY...]: each approximation alone against rays at the
// same points. Writes CSV files for the plots and Markdown tables for docs/accuracy, see
// docs/accuracy/run.
#include <fmt/format.h>

#include <charconv>
#include <set>

#include "accuracy_gradients.h"
#include "accuracy_hemisphere.h"
#include "accuracy_raster.h"
#include "accuracy_sh.h"
#include "accuracy_yardstick.h"
#include "core/error.h"
#include "core/timer.h"

namespace {

using namespace sheen;

const std::vector<std::string> kScenes = {"cornell_glossy", "venus_glossy", "atrium"};
// With the box where nothing is glossy, so that light on surfaces does not change with the eye.
const std::vector<std::string> kAllScenes = {"cornell_diffuse", "cornell_glossy", "venus_glossy",
                                             "atrium"};
// Sites a scene of the committed tables.
constexpr int kProjectionSites = 1000;
constexpr int kHemisphereSites = 3334;  // 10,000 in all, as Table 8.1 of [GKB09]
constexpr int kRasterSites = 334;       // 1,000 in all
constexpr int kSizeSites = 400;
constexpr int kYardstickSites = 1000;
constexpr int kGradientSites = 150;

const std::set<std::string> kStudies = {"sh",    "hemispheres", "raster",
                                        "sizes", "yardstick",   "gradients"};

int parseCount(const std::string& text) {
    int count = 0;
    const char* end = text.data() + text.size();
    if (std::from_chars(text.data(), end, count).ptr != end || count < 1) {
        throwUsage("--records {}: must be a number above 0", text);
    }
    return count;
}

void measure(const std::vector<std::string>& arguments) {
    int records = 0;
    std::set<std::string> studies;
    for (size_t i = 2; i < arguments.size(); ++i) {
        if (arguments[i] == "--records" && i + 1 < arguments.size()) {
            records = parseCount(arguments[++i]);
        } else if (kStudies.count(arguments[i]) > 0) {
            studies.insert(arguments[i]);
        } else {
            throwUsage("{}: no such study or option", arguments[i]);
        }
    }
    const auto wanted = [&studies](const char* study) {
        return studies.empty() || studies.count(study) > 0;
    };
    const bench::Output output{arguments[1]};
    const auto run = [&](const char* study, const std::vector<std::string>& scenes, int full,
                         auto&& body) {
        if (wanted(study)) {
            const Timer timer;
            const int sites = records > 0 ? std::min(records, full) : full;
            body(bench::loadBenchScenes(arguments[0], scenes, sites), sites, output);
            fmt::print(stderr, "accuracy: {}: {} sites a scene, {:.0f} s\n", study, sites,
                       timer.seconds());
        }
    };
    run("sh", kScenes, kProjectionSites, bench::studyProjection);
    run("hemispheres", kScenes, kHemisphereSites, bench::studyHemispheres);
    run("raster", kScenes, kRasterSites, bench::studyRaster);
    run("sizes", kScenes, kSizeSites, bench::studyHemisphereSizes);
    run("yardstick", kAllScenes, kYardstickSites, bench::studyYardstick);
    run("gradients", kAllScenes, kGradientSites, bench::studyGradients);
}

}  // namespace

int main(int argc, char** argv) {
    try {
        if (argc < 3) {
            throwUsage(
                "usage: accuracy SCENES OUTPUT [--records N] "
                "[sh|hemispheres|raster|sizes|yardstick|gradients]...");
        }
        measure({argv + 1, argv + argc});
        return 0;
    } catch (const Error& error) {
        fmt::print(stderr, "accuracy: {}\n", error.what());
        return static_cast<int>(error.code());
    } catch (const std::exception& error) {
        fmt::print(stderr, "accuracy: bug: {}\n", error.what());
        return 1;
    }
}
