// Progress of long work on stderr: a bar on a terminal, a plain line every tenth elsewhere; or told
// to a listener.
#pragma once

#include <cstdint>
#include <mutex>
#include <string>

#include "core/listener.h"
#include "core/timer.h"

namespace sheen {

/// Thread-safe. Prints nothing for work that ends within half a second. Where the thread that makes
/// it has a listener, that one is told of each percent instead, and nothing is printed.
class Progress {
  public:
    /// `total` steps; `label` names the work. A quiet progress prints nothing.
    Progress(std::string label, int64_t total, bool quiet = false);
    /// Ends the bar's line.
    ~Progress();
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;

    void advance(int64_t steps = 1);

  private:
    void print();
    void tell(int percent);

    std::string label_;
    int64_t total_;
    bool quiet_;
    const Listener* listener_;  // null: standard error
    bool terminal_;
    int64_t done_ = 0;
    int printed_percent_ = -1;
    std::mutex mutex_;
    Timer timer_;
};

}  // namespace sheen
