#include "cache/coverage.h"

#include <algorithm>

#include "receivers/served.h"

namespace sheen {
namespace {

// Weights are summed in fixed point, so that taking a record's weights back is exact and the sum
// does not depend on the order of summation.
constexpr float kWeightScale = 4096.0f;
constexpr float kWeightLimit = 64.0f;
const auto kCovered = static_cast<uint32_t>(shared::MIN_WEIGHT_SUM * kWeightScale);

}  // namespace

Coverage::Coverage(const Receivers& receivers, const ReachBounds& bounds,
                   const WeightParams& weight)
    : receivers_(receivers),
      bounds_(bounds),
      weight_(weight),
      sums_(receivers.positions.size()),
      given_up_(receivers.positions.size()) {}

bool Coverage::uncovered(size_t i) const {
    return receivers_.orders[i] != kNoOrder && sums_[i] <= kCovered;
}

int Coverage::countUncovered() const {
    int count = 0;
    for (size_t i = 0; i < sums_.size(); ++i) {
        count += uncovered(i) ? 1 : 0;
    }
    return count;
}

void Coverage::splat(const Record& record, bool add) {
    const auto may_serve = [&](size_t i) { return bounds_.mayServe(record.radius, i); };
    forServed(receivers_, record, weight_, may_serve, [&](size_t i, float v) {
        const auto fixed = static_cast<uint32_t>(std::min(v, kWeightLimit) * kWeightScale + 0.5f);
        sums_[i] = add ? sums_[i] + fixed : sums_[i] - fixed;
    });
}

}  // namespace sheen
