#include "core/parallel.h"

#include <tbb/blocked_range.h>
#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>

#include <memory>

#include "core/error.h"

namespace sheen {
namespace {

std::unique_ptr<tbb::global_control> g_limit;
int g_threads = 0;
thread_local const std::atomic<bool>* t_stop = nullptr;

}  // namespace

StopScope::StopScope(const std::atomic<bool>& stop) : before_(t_stop) { t_stop = &stop; }
StopScope::~StopScope() { t_stop = before_; }

void setThreadCount(int threads) {
    SHEEN_CHECK(threads >= 0);
    g_threads = threads;
    g_limit.reset();
    if (threads > 0) {
        g_limit = std::make_unique<tbb::global_control>(
            tbb::global_control::max_allowed_parallelism, static_cast<size_t>(threads));
    }
}

int threadCount() { return g_threads > 0 ? g_threads : tbb::info::default_concurrency(); }

void parallelFor(int count, const std::function<void(int)>& body, int grain) {
    const std::atomic<bool>* const stop = t_stop;
    tbb::parallel_for(tbb::blocked_range<int>(0, count, static_cast<size_t>(grain)),
                      [&](const tbb::blocked_range<int>& range) {
                          for (int i = range.begin(); i < range.end(); ++i) {
                              if (stop != nullptr && stop->load(std::memory_order_relaxed)) {
                                  throw Stopped();
                              }
                              body(i);
                          }
                      });
}

}  // namespace sheen
