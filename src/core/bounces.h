// How often light is scattered on its way.
#pragma once

#include <limits>

namespace sheen {

/// As often as it is: no limit.
constexpr int kAllBounces = std::numeric_limits<int>::max();

}  // namespace sheen
