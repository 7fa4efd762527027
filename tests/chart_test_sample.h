// A chart made by hand, for the tests of its report: two scenes, three methods, hostile names.
#pragma once

#include "chart/chart.h"

namespace sheen {

/// Not UTF-8 at its end, and what would end a script element, an attribute, a CSV cell.
extern const char* const kHostileName;

/// Scene 0: all judged, of which each method's first point is slower and worse than the next.
/// Scene 1, called kHostileName: one point not judged, one of no error, one of infinite error.
Chart sampleChart();

}  // namespace sheen
