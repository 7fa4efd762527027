#include "mpi/mpi_ranks.h"

#include <mpi.h>
#include <sched.h>

#include <algorithm>
#include <cstdio>
#include <cstring>
#include <numeric>

#include "core/error.h"

namespace sheen {
namespace {

// This rank's share of the processors it may run on: other ranks of its host may have the same.
int processorsOfThisRank() {
    MPI_Comm host = MPI_COMM_NULL;
    MPI_Comm_split_type(MPI_COMM_WORLD, MPI_COMM_TYPE_SHARED, 0, MPI_INFO_NULL, &host);
    int count = 0;
    MPI_Comm_size(host, &count);
    cpu_set_t own;
    CPU_ZERO(&own);
    sched_getaffinity(0, sizeof(own), &own);
    std::vector<cpu_set_t> all(static_cast<size_t>(count));
    MPI_Allgather(&own, sizeof(own), MPI_BYTE, all.data(), sizeof(own), MPI_BYTE, host);
    MPI_Comm_free(&host);
    const auto sharing = std::count_if(all.begin(), all.end(), [&](const cpu_set_t& other) {
        return CPU_EQUAL(&own, &other) != 0;
    });
    return std::max(1, CPU_COUNT(&own) / static_cast<int>(sharing));
}

std::string hostName() {
    char name[MPI_MAX_PROCESSOR_NAME];
    int length = 0;
    MPI_Get_processor_name(name, &length);
    return {name, static_cast<size_t>(length)};
}

}  // namespace

MpiRanks::MpiRanks(const std::string& identity) {
    int provided = 0;
    MPI_Init_thread(nullptr, nullptr, MPI_THREAD_FUNNELED, &provided);
    SHEEN_CHECK(provided >= MPI_THREAD_FUNNELED);
    MPI_Comm_rank(MPI_COMM_WORLD, &rank_);
    MPI_Comm_size(MPI_COMM_WORLD, &count_);
    threads_ = processorsOfThisRank();
    if (first()) {
        greet(identity);
        local_ = std::make_unique<LocalWorker>();
    } else {
        send(0, MessageKind::kHello, {identity, hostName()});
        muted_.emplace(mute_);
        SHEEN_CHECK(std::freopen("/dev/null", "w", stdout) != nullptr);
    }
}

MpiRanks::~MpiRanks() {
    if (first()) {
        ranks_[0].state = State::kLeftOut;  // its own unit, if any, is dropped
        for (int rank = 1; rank < count_; ++rank) {
            send(rank, MessageKind::kLeave, {});
        }
        while (anyIn(State::kPreparing) || anyIn(State::kBusy)) {
            ranks_[static_cast<size_t>(await().from)].state = State::kLeftOut;
        }
    } else if (!let_go_) {
        serve({}, {}, {});
    }
    MPI_Finalize();
}

bool MpiRanks::anyIn(State state) const {
    return std::any_of(ranks_.begin(), ranks_.end(),
                       [state](const Other& other) { return other.state == state; });
}

// Hears who the others are.
void MpiRanks::greet(const std::string& identity) {
    ranks_.resize(static_cast<size_t>(count_));
    ranks_[0] = {.host = hostName(), .state = State::kFree};
    std::vector<std::string> identities(ranks_.size(), identity);
    for (int heard = 1; heard < count_; ++heard) {
        const Message hello = await(MessageKind::kHello);
        SHEEN_CHECK_EQ(hello.texts.size(), 2u);
        identities[static_cast<size_t>(hello.from)] = hello.texts[0];
        ranks_[static_cast<size_t>(hello.from)].host = hello.texts[1];
    }
    for (int rank = 1; rank < count_; ++rank) {
        const std::string& other = identities[static_cast<size_t>(rank)];
        if (other != identity) {
            leaveOut(rank, fmt::format("is {}, the first rank {}", other, identity));
        }
    }
}

void MpiRanks::leaveOut(int rank, const std::string& why) {
    Other& other = ranks_[static_cast<size_t>(rank)];
    other.state = State::kLeftOut;
    warn(fmt::format("rank {} on {}: {}; the others go on without it", rank, other.host, why));
}

void MpiRanks::answered(Sharing& sharing, size_t unit, const Outcome& outcome) {
    for (const std::string& warning : outcome.warnings) {
        if (warned_.insert(warning).second) {
            warn(warning);
        }
    }
    ++sharing.answered;
    sharing.done(unit, outcome.answer);
}

// Of an error in that unit, if it was in one.
void MpiRanks::failed(Sharing& sharing, std::optional<size_t> unit, int rank,
                      const Failure& failure) {
    Other& other = ranks_[static_cast<size_t>(rank)];
    if (!sharing.ending) {
        sharing.failure = {failure.code,
                           fmt::format("rank {} on {}: {}", rank, other.host, failure.message)};
    }
    if (unit && failure.code != ExitCode::kEnvironment) {
        sharing.ending = true;  // any rank would fail at it
        other.state = State::kLeftOut;
        return;
    }
    if (unit) {
        sharing.left.push_back(*unit);
    }
    leaveOut(rank, failure.message);
}

void MpiRanks::hear(const Message& message, Sharing& sharing) {
    Other& other = ranks_[static_cast<size_t>(message.from)];
    if (message.kind == MessageKind::kFailed && other.state != State::kLeftOut) {
        const bool busy = other.state == State::kBusy;
        failed(sharing, busy ? std::optional<size_t>(other.unit) : std::nullopt, message.from,
               {static_cast<ExitCode>(std::stoi(message.texts.at(0))), message.texts.at(1)});
    } else if (message.kind == MessageKind::kReady && other.state == State::kPreparing) {
        other.state = State::kFree;
        other.job = message.texts.at(0);
    } else if (message.kind == MessageKind::kDone) {
        other.state = State::kFree;
        answered(sharing, other.unit,
                 {message.texts.at(0), {message.texts.begin() + 1, message.texts.end()}});
    }
}

// Whether the local worker had anything to say.
bool MpiRanks::hearLocal(Sharing& sharing) {
    Other& self = ranks_[0];
    if (self.state != State::kBusy) {
        return false;
    }
    std::optional<Outcome> outcome;
    try {
        outcome = local_->take();
    } catch (...) {
        failed(sharing, self.unit, 0, failureOf(std::current_exception()));
        return true;
    }
    if (outcome) {
        self.state = State::kFree;
        answered(sharing, self.unit, *outcome);
    }
    return outcome.has_value();
}

// Whether anything was.
bool MpiRanks::handOut(const std::string& job, Sharing& sharing) {
    bool any = false;
    for (size_t rank = 0; rank < ranks_.size() && !sharing.left.empty() && !sharing.ending;
         ++rank) {
        Other& other = ranks_[rank];
        if (other.state != State::kFree) {
            continue;
        }
        if (rank > 0 && other.job != job) {
            leaveOut(static_cast<int>(rank), "reads another scene, or has other options");
            continue;
        }
        other.unit = sharing.left.front();
        if (rank == 0) {
            local_->give(sharing.work, sharing.units[other.unit]);
        } else {
            std::vector<std::string> texts = {sharing.units[other.unit]};
            if (other.heard != tellings_) {
                texts.push_back(told_);
                other.heard = tellings_;
            }
            send(static_cast<int>(rank), MessageKind::kUnit, texts);
        }
        other.state = State::kBusy;
        sharing.left.pop_front();
        any = true;
    }
    return any;
}

void MpiRanks::tell(std::string what) {
    SHEEN_CHECK(first());
    if (tellings_ == 0 || what != told_) {
        told_ = std::move(what);
        ++tellings_;
    }
}

void MpiRanks::share(const std::string& job, std::span<const std::string> units, const DoUnit& work,
                     const UnitDone& done) {
    SHEEN_CHECK(first());
    Sharing sharing{.units = units, .work = work, .done = done, .left = {}};
    sharing.left.resize(units.size());
    std::iota(sharing.left.begin(), sharing.left.end(), size_t{0});
    const LocalWorker::Idle idle_at_the_end(*local_);  // also where `done` throws
    Patience patience;
    while (sharing.answered < units.size()) {
        bool news = handOut(job, sharing);
        while (const std::optional<Message> message = receive()) {
            hear(*message, sharing);
            news = true;
        }
        news = hearLocal(sharing) || news;
        const bool could_go_on = anyIn(State::kFree) || anyIn(State::kPreparing);
        if (!anyIn(State::kBusy) && (sharing.ending || !could_go_on)) {
            SHEEN_CHECK(sharing.failure);
            throw Error(sharing.failure->code,
                        fmt::format("{}; {} of {} are done", sharing.failure->message,
                                    sharing.answered, units.size()));
        }
        if (news) {
            patience.reset();
        } else {
            patience.wait();
        }
    }
}

void MpiRanks::serve(const std::string& job, const DoUnit& work, const Hear& hear) {
    SHEEN_CHECK(!first());
    send(0, MessageKind::kReady, {job});
    for (Message message = await(); message.kind != MessageKind::kLeave; message = await()) {
        const auto hear_and_work = [&](const std::string& unit) {
            if (message.texts.size() > 1) {
                SHEEN_CHECK(hear);
                hear(message.texts[1]);
            }
            return work(unit);
        };
        Outcome outcome = outcomeOf(hear_and_work, message.texts.at(0));
        std::vector<std::string>& texts = outcome.warnings;
        texts.insert(texts.begin(), std::move(outcome.answer));
        send(0, MessageKind::kDone, texts);
    }
    let_go_ = true;
}

void MpiRanks::giveUp(const Failure& failure) {
    SHEEN_CHECK(!first());
    if (!let_go_) {
        send(0, MessageKind::kFailed,
             {fmt::format("{}", static_cast<int>(failure.code)), failure.message});
        SHEEN_CHECK(await().kind == MessageKind::kLeave);
        let_go_ = true;
    }
}

}  // namespace sheen
