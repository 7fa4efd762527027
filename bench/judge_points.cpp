// The studies of docs/accuracy/README.md.
#include <fmt/format.h>

#include <algorithm>

#include "accuracy_gradients.h"
#include "accuracy_hemisphere.h"
#include "accuracy_raster.h"
#include "accuracy_sh.h"
#include "accuracy_yardstick.h"
#include "core/timer.h"
#include "judge.h"

namespace sheen::bench {
namespace {

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

}  // namespace

const std::vector<std::string>& pointStudies() {
    static const std::vector<std::string> studies = {"sh",    "hemispheres", "raster",
                                                     "sizes", "yardstick",   "gradients"};
    return studies;
}

void judgePoints(const std::string& scenes, const std::string& folder, int records,
                 const std::vector<std::string>& studies) {
    const auto wanted = [&studies](const char* study) {
        return studies.empty() || std::find(studies.begin(), studies.end(), study) != studies.end();
    };
    const Output output{folder};
    const auto run = [&](const char* study, const std::vector<std::string>& names, int full,
                         auto&& body) {
        if (wanted(study)) {
            const Timer timer;
            const int sites = records > 0 ? std::min(records, full) : full;
            body(loadBenchScenes(scenes, names, sites), sites, output);
            fmt::print(stderr, "judge: {}: {} sites a scene, {:.0f} s\n", study, sites,
                       timer.seconds());
        }
    };
    run("sh", kScenes, kProjectionSites, studyProjection);
    run("hemispheres", kScenes, kHemisphereSites, studyHemispheres);
    run("raster", kScenes, kRasterSites, studyRaster);
    run("sizes", kScenes, kSizeSites, studyHemisphereSizes);
    run("yardstick", kAllScenes, kYardstickSites, studyYardstick);
    run("gradients", kAllScenes, kGradientSites, studyGradients);
}

}  // namespace sheen::bench
