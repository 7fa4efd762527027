#include "image/atomic_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <cstring>
#include <filesystem>

#include "core/error.h"

namespace sheen {
namespace {

namespace fs = std::filesystem;

// Names of the temporaries in flight, readable from a signal handler. A program writes one or two
// files at a time; one that finds the table full is merely not removed on a signal.
constexpr size_t kMaxPathBytes = 4096;
constexpr int kMaxPending = 16;

struct PendingTemporary {
    std::atomic<bool> used{false};   ///< the slot is taken
    std::atomic<bool> ready{false};  ///< `name` is complete
    std::array<char, kMaxPathBytes> name{};
};
std::array<PendingTemporary, kMaxPending> g_pending;

int addPending(const std::string& name) {
    if (name.size() >= kMaxPathBytes) {
        return -1;
    }
    for (int i = 0; i < kMaxPending; ++i) {
        PendingTemporary& slot = g_pending[static_cast<size_t>(i)];
        if (!slot.used.exchange(true)) {
            std::memcpy(slot.name.data(), name.c_str(), name.size() + 1);
            slot.ready = true;
            return i;
        }
    }
    return -1;
}

void dropPending(int index) {
    if (index >= 0) {
        PendingTemporary& slot = g_pending[static_cast<size_t>(index)];
        slot.ready = false;
        slot.used = false;
    }
}

// The name does not hold the target's: that may already be as long as the file system allows.
std::string temporaryName(const std::string& target) {
    static std::atomic<unsigned> counter{0};
    const fs::path folder = fs::path(target).parent_path();
    return (folder / fmt::format(".sheen-{}-{}.tmp", getpid(), counter++)).string();
}

}  // namespace

AtomicFile::AtomicFile(std::string path) : path_(std::move(path)), target_(path_) {
    if (path_.empty()) {
        throwEnvironment("cannot write a file without a name");
    }
    struct stat existing {};
    const bool exists = stat(path_.c_str(), &existing) == 0;
    if (exists) {
        if (S_ISDIR(existing.st_mode)) {
            throwEnvironment("{}: cannot write: is a directory", path_);
        }
        if (!S_ISREG(existing.st_mode)) {
            throwEnvironment("{}: cannot write: is not a regular file", path_);
        }
        if (access(path_.c_str(), W_OK) != 0) {
            throwEnvironment("{}: cannot write: {}", path_, std::strerror(errno));
        }
        std::error_code ignored;
        const fs::path resolved = fs::canonical(path_, ignored);
        target_ = ignored ? path_ : resolved.string();
    }
    do {
        temporary_ = temporaryName(target_);
        file_ = open(temporary_.c_str(), O_CREAT | O_EXCL | O_RDWR | O_CLOEXEC, 0666);
    } while (file_ < 0 && errno == EEXIST);
    if (file_ < 0) {
        throwEnvironment("{}: cannot write: {}", path_, std::strerror(errno));
    }
    if (exists) {
        // A file that is replaced keeps its permissions; failing to do so is harmless.
        [[maybe_unused]] const int unchanged = fchmod(file_, existing.st_mode & 07777);
    }
    slot_ = addPending(temporary_);
}

AtomicFile::~AtomicFile() {
    if (file_ >= 0) {
        close(file_);
    }
    if (!temporary_.empty()) {
        unlink(temporary_.c_str());
    }
    dropPending(slot_);
}

void AtomicFile::fail(int error) {
    error_ = error;
    throwEnvironment("{}: cannot write: {}", path_, std::strerror(error));
}

void AtomicFile::write(const char* data, size_t size) {
    if (error_ != 0) {
        fail(error_);
    }
    while (size > 0) {
        const ssize_t written = ::write(file_, data, size);
        if (written < 0 && errno == EINTR) {
            continue;
        }
        if (written < 0) {
            fail(errno);
        }
        data += written;
        size -= static_cast<size_t>(written);
    }
}

uint64_t AtomicFile::position() {
    const off_t at = lseek(file_, 0, SEEK_CUR);
    if (at < 0) {
        fail(errno);
    }
    return static_cast<uint64_t>(at);
}

void AtomicFile::seek(uint64_t position) {
    if (lseek(file_, static_cast<off_t>(position), SEEK_SET) < 0) {
        fail(errno);
    }
}

void AtomicFile::commit() {
    if (error_ != 0) {
        fail(error_);
    }
    // Network file systems report a full disk only here.
    const int closed = close(file_);
    file_ = -1;
    if (closed != 0) {
        fail(errno);
    }
    if (rename(temporary_.c_str(), target_.c_str()) != 0) {
        fail(errno);
    }
    temporary_.clear();
    dropPending(slot_);
    slot_ = -1;
}

void checkWritable(const std::string& path) { const AtomicFile probe(path); }

void removePendingTemporaries() noexcept {
    for (PendingTemporary& slot : g_pending) {
        if (slot.ready) {
            unlink(slot.name.data());
        }
    }
}

}  // namespace sheen
