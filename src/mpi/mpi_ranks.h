// The ranks of an MPI job: those that `mpirun` started. The first hands out units to whoever is
// free, itself among them.
#pragma once

#include <deque>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "core/failure.h"
#include "core/listener.h"
#include "core/ranks.h"
#include "mpi/local_worker.h"
#include "mpi/messages.h"

namespace sheen {

/// One for a process, made and used by its main thread. Of errors of MPI itself MPI ends the job.
class MpiRanks : public Ranks {
  public:
    /// `identity`: of the program. Ranks of another one are left out, with a warning. Others than
    /// the first print nothing from now on.
    explicit MpiRanks(const std::string& identity);
    /// The first waits until units that are under way have ended, the others until it lets them go.
    ~MpiRanks() override;

    int count() const override { return count_; }
    bool first() const override { return rank_ == 0; }
    int threads() const override { return threads_; }
    void tell(std::string what) override;
    void share(const std::string& job, std::span<const std::string> units, const DoUnit& work,
               const UnitDone& done) override;
    void serve(const std::string& job, const DoUnit& work, const Hear& hear) override;

    /// On others than the first: tells that one why no more units are done here.
    void giveUp(const Failure& failure);

  private:
    enum class State { kPreparing, kFree, kBusy, kLeftOut };
    // A rank as the first one knows it.
    struct Other {
        std::string host = {};
        State state = State::kPreparing;
        size_t unit = 0;  // while busy
        std::string job = {};
        int heard = 0;  // so many of what was told, or of what came later
    };
    // What is shared out.
    struct Sharing {
        std::span<const std::string> units;
        const DoUnit& work;
        const UnitDone& done;
        std::deque<size_t> left;
        size_t answered = 0;
        std::optional<Failure> failure = {};  // that ends it, or of the rank that failed last
        bool ending = false;                  // no unit is begun any more
    };
    void greet(const std::string& identity);
    void hear(const Message& message, Sharing& sharing);
    bool hearLocal(Sharing& sharing);
    bool handOut(const std::string& job, Sharing& sharing);
    void answered(Sharing& sharing, size_t unit, const Outcome& outcome);
    void failed(Sharing& sharing, std::optional<size_t> unit, int rank, const Failure& failure);
    void leaveOut(int rank, const std::string& why);
    bool anyIn(State state) const;

    int rank_ = 0, count_ = 1, threads_ = 0;
    std::vector<Other> ranks_;  // [rank]; of the first: all, itself included
    std::string told_;          // of the first: the last
    int tellings_ = 0;
    std::set<std::string> warned_;
    std::unique_ptr<LocalWorker> local_;  // of the first
    Listener mute_;
    std::optional<ListenerScope> muted_;  // of the others
    bool let_go_ = false;                 // likewise
};

}  // namespace sheen
