#include "chart/measurement.h"

#include <algorithm>
#include <cmath>
#include <fstream>
#include <numeric>

#include "core/error.h"

namespace sheen {

std::string processorName() {
    std::ifstream in("/proc/cpuinfo");
    for (std::string line; std::getline(in, line);) {
        const size_t colon = line.find(": ");
        if (line.rfind("model name", 0) == 0 && colon != std::string::npos) {
            return line.substr(colon + 2);
        }
    }
    return "unknown processor";
}

double Measurement::seconds() const {
    SHEEN_CHECK(!runs.empty());
    std::vector<double> sorted;
    for (const TimedRun& run : runs) {
        sorted.push_back(run.seconds);
    }
    std::sort(sorted.begin(), sorted.end());
    const size_t half = sorted.size() / 2;
    return sorted.size() % 2 == 1 ? sorted[half] : std::midpoint(sorted[half - 1], sorted[half]);
}

const StageTimes& Measurement::stages() const {
    const double median = seconds();
    const auto nearest =
        std::min_element(runs.begin(), runs.end(), [&](const TimedRun& a, const TimedRun& b) {
            return std::abs(a.seconds - median) < std::abs(b.seconds - median);
        });
    return nearest->stages;
}

double Measurement::spent() const {
    double sum = 0;
    for (const TimedRun& run : runs) {
        sum += run.seconds;
    }
    return sum;
}

bool Measurement::isComplete(int repeats) const {
    return static_cast<int>(runs.size()) >= repeats || spent() >= kEnoughSeconds;
}

int runsLeft(double seconds, double spent, int most) {
    const double enough = std::ceil((kEnoughSeconds - spent) / std::max(seconds, 1e-3));
    return most > 0 ? static_cast<int>(std::clamp(enough, 1.0, static_cast<double>(most))) : 0;
}

}  // namespace sheen
