#include "mpi/local_worker.h"

#include <utility>

#include "core/error.h"
#include "core/listener.h"

namespace sheen {

Outcome outcomeOf(const DoUnit& work, const std::string& unit) {
    Outcome outcome;
    const Listener listener{.progress = {}, .warning = [&](const std::string& message) {
                                outcome.warnings.push_back(message);
                            }};
    const ListenerScope scope(listener);
    outcome.answer = work(unit);
    return outcome;
}

LocalWorker::~LocalWorker() {
    {
        const std::lock_guard<std::mutex> lock(mutex_);
        ending_ = true;
    }
    begun_.notify_one();
    thread_.join();
}

void LocalWorker::give(const DoUnit& work, const std::string& unit) {
    {
        const std::lock_guard<std::mutex> lock(mutex_);
        SHEEN_CHECK(work_ == nullptr && !outcome_ && !failure_);
        work_ = &work;
        unit_ = unit;
    }
    begun_.notify_one();
}

std::optional<Outcome> LocalWorker::take() {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (failure_) {
        std::rethrow_exception(std::exchange(failure_, nullptr));
    }
    return std::exchange(outcome_, std::nullopt);
}

// What comes of what is under way is let go.
void LocalWorker::finish() {
    std::unique_lock<std::mutex> lock(mutex_);
    ended_.wait(lock, [this] { return work_ == nullptr; });
    outcome_.reset();
    failure_ = nullptr;
}

void LocalWorker::run() {
    std::unique_lock<std::mutex> lock(mutex_);
    while (true) {
        begun_.wait(lock, [this] { return ending_ || work_ != nullptr; });
        if (work_ == nullptr) {
            return;
        }
        lock.unlock();
        std::optional<Outcome> outcome;
        std::exception_ptr failure;
        try {
            outcome = outcomeOf(*work_, unit_);
        } catch (...) {
            failure = std::current_exception();
        }
        lock.lock();
        work_ = nullptr;
        outcome_ = std::move(outcome);
        failure_ = failure;
        ended_.notify_one();
    }
}

}  // namespace sheen
