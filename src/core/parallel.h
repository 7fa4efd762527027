// Parallel loops over TBB. A loop's body writes only what belongs to its index, so that the result
// never depends on the number of threads.
#pragma once

#include <functional>

namespace sheen {

/// Number of threads used by everything parallel; 0 means one a hardware thread.
void setThreadCount(int threads);
int threadCount();

/// Calls body(i) for i in [0, count), in any order and on any thread; an exception of the body is
/// rethrown here. `grain` is the smallest number of consecutive indices given to one thread.
void parallelFor(int count, const std::function<void(int)>& body, int grain = 1);

}  // namespace sheen
