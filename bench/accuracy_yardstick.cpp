#include "accuracy_yardstick.h"

#include <fmt/format.h>

#include <cmath>
#include <deque>
#include <iterator>

#include "accuracy_gather.h"
#include "accuracy_truth.h"
#include "core/timer.h"

namespace sheen::bench {
namespace {

constexpr int kRings[] = {9, 18, 36, 72};  // 252, 1,026, 4,068 and 16,272 rays
constexpr int kSides[] = {10, 14, 18, 26, 38};

// One way to gather at the sites of one scene.
struct Way {
    std::string name;
    int size;  // rings, or texels a side
    double rays = 0.0;
    double seconds = 0.0;
    std::vector<float> irradiance = {};

    double millisecondsARecord() const {
        return 1e3 * seconds / static_cast<double>(irradiance.size());
    }
};

// A power law through (error, time), by least squares in logarithms; errors that the truth's noise
// hides, 0, tell nothing.
struct CostOfError {
    double exponent = 0.0;
    double log_scale = 0.0;

    CostOfError(std::span<const double> errors, std::span<const double> times) {
        double n = 0.0, x = 0.0, y = 0.0, xx = 0.0, xy = 0.0;
        for (size_t i = 0; i < errors.size(); ++i) {
            if (errors[i] <= 0.0) {
                continue;
            }
            n += 1.0;
            const double u = std::log(errors[i]), v = std::log(times[i]);
            x += u;
            y += v;
            xx += u * u;
            xy += u * v;
        }
        exponent = (n * xy - x * y) / (n * xx - x * x);
        log_scale = (y - exponent * x) / n;
    }
    double at(double error) const { return std::exp(log_scale + exponent * std::log(error)); }
};

std::vector<Way> gatherEveryWay(const BenchScene& scene, int sites) {
    const ScatteredOnce light(scene.tracer, nullptr, {});
    const RayScene rays(scene.scene);
    std::vector<Way> ways;
    std::vector<WardStrata> strata;
    for (int rings : kRings) {
        ways.push_back({.name = "Embree", .size = rings});
        strata.emplace_back(rings);
    }
    std::deque<RayGatherer> gatherers;
    std::vector<std::vector<RecordSite>> told;  // of each gatherer
    for (int side : kSides) {
        ways.push_back({.name = "gather", .size = side});
        gatherers.emplace_back(light, HemisphereParams{.size = side});
        told.emplace_back(scene.sites.begin(), scene.sites.begin() + sites);
        tellContrasts(gatherers.back(), told.back());
    }
    // All ways take turns, batch by batch, so that they meet the same conditions.
    for (size_t first = 0; first < static_cast<size_t>(sites); first += kBatch) {
        const size_t count = std::min(kBatch, static_cast<size_t>(sites) - first);
        for (size_t w = 0; w < ways.size(); ++w) {
            const Timer timer;
            if (w < strata.size()) {
                const YardstickRecords found = gatherByYardstick(
                    rays, std::span(scene.sites).subspan(first, count), strata[w]);
                ways[w].seconds += timer.seconds();
                ways[w].rays += static_cast<double>(strata[w].count()) * count;
                for (const vec3& e : found.irradiance) {
                    ways[w].irradiance.push_back(grey(e));
                }
            } else {
                const size_t g = w - strata.size();
                const int64_t before = gatherers[g].rays();
                const std::vector<GatheredRecord> found =
                    gatherers[g].gather(std::span(told[g]).subspan(first, count));
                ways[w].seconds += timer.seconds();
                ways[w].rays += static_cast<double>(gatherers[g].rays() - before);
                for (const GatheredRecord& record : found) {
                    ways[w].irradiance.push_back(grey(record.record.irradiance));
                }
            }
        }
    }
    return ways;
}

}  // namespace

void studyYardstick(const BenchScenes& scenes, int sites, const Output& output) {
    const auto count = static_cast<size_t>(sites);
    const hemispheres::Truth truth = hemispheres::traceTruth(scenes, sites, 1);
    std::string csv = "scene,way,size,rays,irradiance,ms,ratio\n";
    Table table({"scene", "way", "rings or texels", "rays a record", "irradiance", "ms a record",
                 "over Embree at this error"});
    for (size_t s = 0; s < scenes.size(); ++s) {
        const std::vector<Way> ways = gatherEveryWay(*scenes[s], sites);
        const std::span truth_values = std::span(truth.values.of[0]).subspan(s * count, count);
        const std::span variance = std::span(truth.variance.of[0]).subspan(s * count, count);
        std::vector<double> errors, times;
        for (const Way& way : ways) {
            errors.push_back(errorsOf(way.irradiance, truth_values, variance).rel_rmse);
            times.push_back(way.millisecondsARecord());
        }
        const CostOfError embree({errors.data(), std::size(kRings)},
                                 {times.data(), std::size(kRings)});
        for (size_t w = 0; w < ways.size(); ++w) {
            const bool own = w >= std::size(kRings);
            const double ratio = errors[w] > 0.0 ? times[w] / embree.at(errors[w]) : 0.0;
            const double rays = ways[w].rays / sites;
            csv += fmt::format("{},{},{},{:.0f},{},{},{}\n", scenes[s]->name, ways[w].name,
                               ways[w].size, rays, errors[w], times[w], ratio);
            table.add({w == 0 ? scenes[s]->name : "", ways[w].name, std::to_string(ways[w].size),
                       fmt::format("{:.0f}", rays), percent(errors[w]),
                       fmt::format("{:.3g}", times[w]),
                       own && ratio > 0.0 ? fmt::format("{:.2g}", ratio) : ""});
        }
    }
    output.write("yardstick.csv", csv);
    output.write("yardstick.md",
                 fmt::format("{}\n{} points a scene. Errors of 0: below the truth's noise.\n",
                             table.text(), sites));
}

}  // namespace sheen::bench
