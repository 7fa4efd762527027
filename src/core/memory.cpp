#include "core/memory.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <limits>
#include <optional>

#include "core/error.h"

namespace sheen {
namespace {

namespace fs = std::filesystem;

constexpr uint64_t kUnlimited = std::numeric_limits<uint64_t>::max();

// The number that a file holds; none where it says "max", or is not there.
std::optional<uint64_t> numberIn(const fs::path& file) {
    std::ifstream in(file);
    uint64_t number = 0;
    return in >> number ? std::optional(number) : std::nullopt;
}

// The number behind a word such as "MemAvailable:".
uint64_t numberBehind(const fs::path& file, const std::string& word) {
    std::ifstream in(file);
    uint64_t number = 0;
    for (std::string found; in >> found;) {
        if (found == word && in >> number) {
            return number;
        }
    }
    return 0;
}

uint64_t freeOnMachine() {
    constexpr uint64_t kKibi = 1024;
    const uint64_t available = numberBehind("/proc/meminfo", "MemAvailable:") * kKibi;
    return available == 0 ? kUnlimited
                          : available + numberBehind("/proc/meminfo", "SwapFree:") * kKibi;
}

// What a control group and those around it leave. Pages of files that were read count as used
// there, but make way.
uint64_t leftInGroup(const fs::path& root, fs::path group, const char* limit_file,
                     const char* used_file) {
    uint64_t left = kUnlimited;
    for (;; group = group.parent_path()) {
        const fs::path folder = root / group.relative_path();
        const std::optional<uint64_t> limit = numberIn(folder / limit_file);
        const std::optional<uint64_t> used = numberIn(folder / used_file);
        if (limit && used) {
            const uint64_t files = numberBehind(folder / "memory.stat", "inactive_file");
            const uint64_t held = *used - std::min(*used, files);
            left = std::min(left, *limit - std::min(*limit, held));
        }
        if (group.empty() || group == group.root_path()) {
            return left;
        }
    }
}

// Of both versions: a line is "ID:CONTROLLERS:GROUP", without controllers in the second.
uint64_t leftInGroups() {
    uint64_t left = kUnlimited;
    std::ifstream in("/proc/self/cgroup");
    for (std::string line; std::getline(in, line);) {
        const size_t first = line.find(':');
        const size_t second = line.find(':', first + 1);
        if (second == std::string::npos) {
            continue;
        }
        const std::string controllers = line.substr(first + 1, second - first - 1);
        const fs::path group = line.substr(second + 1);
        if (controllers.empty()) {
            left = std::min(left,
                            leftInGroup("/sys/fs/cgroup", group, "memory.max", "memory.current"));
        } else if (controllers == "memory") {
            left = std::min(left, leftInGroup("/sys/fs/cgroup/memory", group,
                                              "memory.limit_in_bytes", "memory.usage_in_bytes"));
        }
    }
    return left;
}

uint64_t leftBelowLimit(int resource, const char* used_word, int threads) {
    // Stacks and heaps of each; libraries start some of their own.
    constexpr uint64_t kAddressesPerThread = uint64_t{160} << 20;
    constexpr uint64_t kAddressesOfLibraries = uint64_t{320} << 20;
    constexpr uint64_t kKibi = 1024;
    struct rlimit limit {};
    if (getrlimit(static_cast<__rlimit_resource>(resource), &limit) != 0 ||
        limit.rlim_cur == RLIM_INFINITY) {
        return kUnlimited;
    }
    uint64_t used = numberBehind("/proc/self/status", used_word) * kKibi;
    if (threads > 0) {
        used += kAddressesOfLibraries + kAddressesPerThread * static_cast<uint64_t>(threads);
    }
    return limit.rlim_cur - std::min<uint64_t>(limit.rlim_cur, used);
}

std::string sizeText(uint64_t bytes) {
    constexpr double kMebi = 1024.0 * 1024.0;
    const double mebibytes = static_cast<double>(bytes) / kMebi;
    return mebibytes < 1024.0 ? fmt::format("{:.0f} MiB", mebibytes)
                              : fmt::format("{:.3g} GiB", mebibytes / 1024.0);
}

}  // namespace

uint64_t memoryLeft(int threads) {
    return std::min({freeOnMachine(), leftInGroups(), leftBelowLimit(RLIMIT_AS, "VmSize:", threads),
                     leftBelowLimit(RLIMIT_DATA, "VmData:", threads)});
}

void checkMemory(const MemoryNeed& need, const std::string& what, const std::string& mend) {
    const uint64_t left = memoryLeft(need.threads);
    if (need.bytes > left) {
        throwEnvironment("{}: takes about {} of memory and {} are left; {}", what,
                         sizeText(need.bytes), sizeText(left), mend);
    }
}

}  // namespace sheen
