// Parallel loops that are stopped.
#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <thread>
#include <vector>

#include "core/parallel.h"

namespace sheen {
namespace {

constexpr int kCount = 1000;

TEST(Parallel, ALoopIsStoppedWhileItRuns) {
    std::atomic<bool> stop = false;
    std::atomic<int> begun = 0, ended = 0;
    const StopScope scope(stop);
    EXPECT_THROW(parallelFor(kCount,
                             [&](int i) {
                                 ++begun;
                                 if (i == kCount / 2) {
                                     stop = true;
                                 }
                                 while (!stop) {
                                     std::this_thread::yield();
                                 }
                                 ++ended;
                             }),
                 Stopped);
    EXPECT_LT(begun, kCount);
    EXPECT_EQ(begun, ended);  // bodies are not torn
}

TEST(Parallel, NothingBeginsOnceItIsStoppedAndAllDoesAfterwards) {
    const std::atomic<bool> stop = true;
    std::atomic<int> begun = 0;
    const auto body = [&](int) { ++begun; };
    {
        const StopScope scope(stop);
        EXPECT_THROW(parallelFor(kCount, body), Stopped);
        EXPECT_EQ(begun, 0);
        const std::atomic<bool> other = false;
        const StopScope inner(other);
        parallelFor(kCount, body);
        EXPECT_EQ(begun, kCount);
    }
    parallelFor(kCount, body);
    EXPECT_EQ(begun, 2 * kCount);
}

TEST(Parallel, OtherThreadsGoOn) {
    const std::atomic<bool> stop = true;
    const StopScope scope(stop);
    std::atomic<int> begun = 0;
    std::thread other([&] { parallelFor(kCount, [&](int) { ++begun; }); });
    other.join();
    EXPECT_EQ(begun, kCount);
}

}  // namespace
}  // namespace sheen
