// Processes that share one piece of work, the ranks of an MPI job, or one that has it all. The
// first rank says what there is to do, as units, and hears what came of each; all of them do units.
#pragma once

#include <functional>
#include <span>
#include <string>

namespace sheen {

/// Does a unit, which says what to do, and answers. The same answer on every rank.
using DoUnit = std::function<std::string(const std::string& unit)>;
/// Hears what the units that follow depend on.
using Hear = std::function<void(const std::string& told)>;
/// Hears the answer to a unit, by its index.
using UnitDone = std::function<void(size_t unit, const std::string& answer)>;

class Ranks {
  public:
    Ranks() = default;
    virtual ~Ranks() = default;
    Ranks(const Ranks&) = delete;
    Ranks& operator=(const Ranks&) = delete;

    virtual int count() const = 0;
    /// Whether this is the one that shares out. It alone prints.
    virtual bool first() const = 0;
    /// A rank's share of its machine's processors; 0: all of them.
    virtual int threads() const = 0;

    /// On the first rank: what the others hear before they do units of any share() that follows,
    /// each once.
    virtual void tell(std::string what) = 0;

    /// On the first rank: has every unit done, each by whichever rank is free, and tells `done` as
    /// answers come, one at a time. `job` says what ranks must agree upon. A rank whose machine
    /// fails it (environment errors) is left out with a warning, and its unit is done last, by
    /// another; other errors of a unit, and that of the last rank, are thrown once all units that
    /// were begun have ended.
    virtual void share(const std::string& job, std::span<const std::string> units,
                       const DoUnit& work, const UnitDone& done) = 0;

    /// On the others: does units of that job until the first rank has no more, ever. `hear`: what
    /// it tells them; none where it tells nothing.
    virtual void serve(const std::string& job, const DoUnit& work, const Hear& hear) = 0;
};

/// One process, which does one unit after the other.
class OneRank : public Ranks {
  public:
    int count() const override { return 1; }
    bool first() const override { return true; }
    int threads() const override { return 0; }
    void tell(std::string) override {}
    void share(const std::string&, std::span<const std::string> units, const DoUnit& work,
               const UnitDone& done) override {
        for (size_t i = 0; i < units.size(); ++i) {
            done(i, work(units[i]));
        }
    }
    void serve(const std::string&, const DoUnit&, const Hear&) override {}
};

/// What ranks do together.
struct RankedJob {
    Ranks* ranks = nullptr;  ///< none: one process alone
    std::string text = {};   ///< what they must agree upon

    bool isShared() const { return ranks != nullptr && ranks->count() > 1; }
    /// Whether this is the process that has the result.
    bool first() const { return ranks == nullptr || ranks->first(); }
};

}  // namespace sheen
