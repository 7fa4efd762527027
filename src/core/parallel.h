// Parallel loops over TBB. A loop's body writes only what belongs to its index, so that the result
// never depends on the number of threads.
#pragma once

#include <atomic>
#include <functional>

namespace sheen {

/// Number of threads used by everything parallel; 0 means one a hardware thread.
void setThreadCount(int threads);
int threadCount();

/// Thrown by loops whose work is not wanted any more.
struct Stopped {};

/// While it lives, loops that this thread begins throw Stopped soon after `stop`, which another
/// thread may set, has become true. A body that has begun runs to its end, or to a loop of its own.
class StopScope {
  public:
    explicit StopScope(const std::atomic<bool>& stop);
    ~StopScope();
    StopScope(const StopScope&) = delete;
    StopScope& operator=(const StopScope&) = delete;

  private:
    const std::atomic<bool>* before_;
};

/// Calls body(i) for i in [0, count), in any order and on any thread; an exception of the body is
/// rethrown here. `grain` is the smallest number of consecutive indices given to one thread.
void parallelFor(int count, const std::function<void(int)>& body, int grain = 1);

}  // namespace sheen
