// How much memory is left, so that work which needs more is refused before it begins: an allocator
// that hands out what is not there ends in a kill, not in an error.
#pragma once

#include <cstdint>
#include <string>

namespace sheen {

struct MemoryNeed {
    uint64_t bytes = 0;
    int threads = 0;  ///< each reserves addresses, which limits count, but no memory
};

/// Bytes that this process can still take beside so many threads: the least of what is free on the
/// machine, in its control groups, and below its limits (ulimit -v, -d).
uint64_t memoryLeft(int threads = 0);

/// Environment error where work needs more than memoryLeft(): "WHAT: takes about 97 GiB of memory
/// and 23.1 GiB are left; HOW TO MEND IT".
void checkMemory(const MemoryNeed& need, const std::string& what, const std::string& mend);

}  // namespace sheen
