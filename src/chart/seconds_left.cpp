#include <map>
#include <utility>

#include "chart/chart.h"
#include "chart/measurement.h"

namespace sheen {

double secondsLeft(std::span<const SweepJob> jobs) {
    struct Sum {
        double seconds = 0, cost = 0;
    };
    std::map<std::pair<size_t, size_t>, Sum> done;  // of a scene and a method
    for (const SweepJob& job : jobs) {
        if (job.seconds >= 0) {
            Sum& sum = done[{job.scene, job.method}];
            sum.seconds += job.seconds;
            sum.cost += job.cost;
        }
    }
    if (done.empty()) {
        return -1;
    }
    // Methods differ more than scenes in what a unit of cost takes, so each counts as much.
    const auto mean_ratio = [&done](const auto& counts) {
        double ratios = 0;
        int count = 0;
        for (const auto& [key, sum] : done) {
            if (counts(key.first)) {
                ratios += sum.seconds / sum.cost;
                ++count;
            }
        }
        return count > 0 ? ratios / count : -1.0;
    };
    double left = 0;
    for (const SweepJob& job : jobs) {
        if (job.seconds >= 0) {
            left += job.seconds * runsLeft(job.seconds, job.spent, job.repeats - job.runs);
            continue;
        }
        const auto same = done.find({job.scene, job.method});
        double ratio = same != done.end()
                           ? same->second.seconds / same->second.cost
                           : mean_ratio([&job](size_t scene) { return scene == job.scene; });
        if (ratio < 0) {
            ratio = mean_ratio([](size_t) { return true; });
        }
        left += job.cost * ratio * runsLeft(job.cost * ratio, 0, job.repeats);
    }
    return left;
}

}  // namespace sheen
