#include "chart/measurement.h"

#include <algorithm>
#include <cmath>

#include "core/error.h"

namespace sheen {

double Measurement::seconds() const {
    SHEEN_CHECK(!runs.empty());
    std::vector<double> sorted;
    for (const TimedRun& run : runs) {
        sorted.push_back(run.seconds);
    }
    std::sort(sorted.begin(), sorted.end());
    const size_t half = sorted.size() / 2;
    return sorted.size() % 2 == 1 ? sorted[half] : 0.5 * (sorted[half - 1] + sorted[half]);
}

const StageTimes& Measurement::stages() const {
    const double median = seconds();
    const auto nearest =
        std::min_element(runs.begin(), runs.end(), [&](const TimedRun& a, const TimedRun& b) {
            return std::abs(a.seconds - median) < std::abs(b.seconds - median);
        });
    return nearest->stages;
}

bool Measurement::isComplete(int repeats) const {
    double spent = 0;
    for (const TimedRun& run : runs) {
        spent += run.seconds;
    }
    return static_cast<int>(runs.size()) >= repeats || spent >= kEnoughSeconds;
}

int plannedRuns(double seconds, int repeats) {
    const double enough = std::ceil(kEnoughSeconds / std::max(seconds, 1e-3));
    return static_cast<int>(std::clamp(enough, 1.0, static_cast<double>(repeats)));
}

}  // namespace sheen
