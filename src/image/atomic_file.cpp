#include "image/atomic_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <cstdio>
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

// It does not hold the target's name, which may already be as long as the file system allows.
std::string temporaryName(unsigned process, unsigned count) {
    return fmt::format(".sheen-{}-{}.tmp", process, count);
}

bool isTemporaryName(const std::string& name) {
    unsigned process = 0;
    unsigned count = 0;
    return std::sscanf(name.c_str(), ".sheen-%u-%u.tmp", &process, &count) == 2 &&
           name == temporaryName(process, count);
}

fs::path folderOf(const std::string& file) {
    const fs::path folder = fs::path(file).parent_path();
    return folder.empty() ? "." : folder;
}

// Where a name leads that may be a link to what does not exist yet.
std::string followLinks(const std::string& path) {
    constexpr int kMaxLinks = 40;  // as in the kernel; they may lead in a circle
    std::error_code error;
    fs::path target = path;
    for (int i = 0; i < kMaxLinks && fs::is_symlink(fs::symlink_status(target, error)); ++i) {
        target = target.parent_path() / fs::read_symlink(target, error);
    }
    return target.string();
}

// Locks the temporary until its process ends, however it ends: one that is not locked is a
// leftover. False where it was taken for one before.
bool claim(int file) {
    while (flock(file, LOCK_EX) != 0 && errno == EINTR) {
    }
    struct stat status {};
    return fstat(file, &status) != 0 || status.st_nlink > 0;
}

// Removes the temporaries in a folder whose processes were killed.
void removeLeftovers(const fs::path& folder) {
    std::error_code error;
    for (fs::directory_iterator entry(folder, error), end; !error && entry != end;
         entry.increment(error)) {
        if (!isTemporaryName(entry->path().filename().string())) {
            continue;
        }
        const int file = open(entry->path().c_str(), O_RDWR | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC);
        if (file < 0) {
            continue;  // another user's
        }
        struct stat status {};
        if (fstat(file, &status) == 0 && S_ISREG(status.st_mode) &&
            flock(file, LOCK_EX | LOCK_NB) == 0) {
            unlink(entry->path().c_str());
        }
        close(file);
    }
}

}  // namespace

AtomicFile::AtomicFile(std::string path) : path_(std::move(path)), target_(path_) {
    if (path_.empty()) {
        throwEnvironment("cannot write a file without a name");
    }
    struct stat existing {};
    const bool exists = stat(path_.c_str(), &existing) == 0;
    if (!exists && errno != ENOENT) {  // such as a name that is too long
        throwEnvironment("{}: cannot write: {}", path_, std::strerror(errno));
    }
    if (exists) {
        checkReplaceable(existing.st_mode, existing.st_uid);
        std::error_code ignored;
        const fs::path resolved = fs::canonical(path_, ignored);
        target_ = ignored ? path_ : resolved.string();
    } else {
        target_ = followLinks(path_);
    }
    makeTemporary();
    if (exists) {
        // A file that is replaced keeps its permissions; failing to do so is harmless.
        [[maybe_unused]] const int unchanged = fchmod(file_, existing.st_mode & 07777);
    }
    slot_ = addPending(temporary_);
}

void AtomicFile::checkReplaceable(unsigned mode, unsigned owner) const {
    if (S_ISDIR(mode)) {
        throwEnvironment("{}: cannot write: is a directory", path_);
    }
    if (!S_ISREG(mode)) {
        throwEnvironment("{}: cannot write: is not a regular file", path_);
    }
    if (access(path_.c_str(), W_OK) != 0) {
        throwEnvironment("{}: cannot write: {}", path_, std::strerror(errno));
    }
    struct stat folder {};
    const unsigned user = geteuid();
    if (user != 0 && user != owner && stat(folderOf(path_).c_str(), &folder) == 0 &&
        (folder.st_mode & S_ISVTX) != 0 && user != folder.st_uid) {
        throwEnvironment(
            "{}: cannot write: belongs to another user, and in this folder only they may replace "
            "it; choose another name",
            path_);
    }
}

void AtomicFile::makeTemporary() {
    static std::atomic<unsigned> counter{0};
    for (;;) {
        const std::string name = temporaryName(static_cast<unsigned>(getpid()), counter++);
        temporary_ = (folderOf(target_) / name).string();
        file_ = open(temporary_.c_str(), O_CREAT | O_EXCL | O_RDWR | O_CLOEXEC, 0666);
        if (file_ < 0 && errno != EEXIST) {
            temporary_.clear();
            throwEnvironment("{}: cannot write{}: {}", path_,
                             target_ == path_ ? "" : fmt::format(" to {}", target_),
                             std::strerror(errno));
        }
        if (file_ >= 0 && claim(file_)) {
            return;
        }
        if (file_ >= 0) {
            close(file_);
            file_ = -1;
        }
    }
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

void checkWritable(const std::string& path) {
    const AtomicFile probe(path);
    removeLeftovers(folderOf(probe.target()));
}

bool isSameFile(const std::string& a, const std::string& b) {
    struct stat file_a {
    }, file_b{};
    const bool a_exists = stat(a.c_str(), &file_a) == 0;
    const bool b_exists = stat(b.c_str(), &file_b) == 0;
    if (a_exists || b_exists) {
        return a_exists && b_exists && file_a.st_dev == file_b.st_dev &&
               file_a.st_ino == file_b.st_ino;
    }
    std::error_code error;
    const fs::path path_a = fs::weakly_canonical(fs::absolute(followLinks(a)), error);
    return !error && path_a == fs::weakly_canonical(fs::absolute(followLinks(b)), error) && !error;
}

void removePendingTemporaries() noexcept {
    for (PendingTemporary& slot : g_pending) {
        if (slot.ready) {
            unlink(slot.name.data());
        }
    }
}

}  // namespace sheen
