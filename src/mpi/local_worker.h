// The first rank's own share of the work, on a thread beside the one that hands out: MPI is asked
// by that one alone.
#pragma once

#include <condition_variable>
#include <exception>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <vector>

#include "core/ranks.h"

namespace sheen {

/// What came of a unit.
struct Outcome {
    std::string answer;
    std::vector<std::string> warnings;
};

/// Does a unit; what it warns of is kept, and what it says of progress is let go.
Outcome outcomeOf(const DoUnit& work, const std::string& unit);

class LocalWorker {
  public:
    LocalWorker() : thread_([this] { run(); }) {}
    ~LocalWorker();
    LocalWorker(const LocalWorker&) = delete;
    LocalWorker& operator=(const LocalWorker&) = delete;

    /// Begins a unit; the one before must have been taken. `work` must outlive it.
    void give(const DoUnit& work, const std::string& unit);
    /// What came of it, once; none while it is under way. Its exception is rethrown.
    std::optional<Outcome> take();

    /// At its end no unit is under way.
    class Idle {
      public:
        explicit Idle(LocalWorker& worker) : worker_(worker) {}
        ~Idle() { worker_.finish(); }
        Idle(const Idle&) = delete;
        Idle& operator=(const Idle&) = delete;

      private:
        LocalWorker& worker_;
    };

  private:
    void run();
    void finish();

    std::mutex mutex_;
    std::condition_variable begun_, ended_;
    const DoUnit* work_ = nullptr;  // null: none is under way
    std::string unit_;
    std::optional<Outcome> outcome_;
    std::exception_ptr failure_;
    bool ending_ = false;
    std::thread thread_;  // last: it uses the others
};

}  // namespace sheen
