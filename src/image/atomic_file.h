// A file that appears whole or not at all: it is written under a temporary name in its own folder
// and renamed when complete. Every file Sheen writes goes through here.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

namespace sheen {

/// Owns the temporary file until commit(). Every failure is an environment error (one line naming
/// the path); a temporary that was not committed is removed by the destructor.
class AtomicFile {
  public:
    /// Creates the temporary beside `path`. A symbolic link is followed, also to what does not
    /// exist yet. Refused: a folder, a device or pipe, a name that is too long, an existing file
    /// that this user may not write or replace.
    explicit AtomicFile(std::string path);
    ~AtomicFile();
    AtomicFile(const AtomicFile&) = delete;
    AtomicFile& operator=(const AtomicFile&) = delete;

    const std::string& path() const { return path_; }
    /// Where it ends up: path() with links followed.
    const std::string& target() const { return target_; }

    /// Writes at the current position. After a failure every later call fails too, so that a caller
    /// which swallows the exception (OpenEXR's destructors do) cannot commit a damaged file.
    void write(const char* data, size_t size);
    void write(std::string_view text) { write(text.data(), text.size()); }
    uint64_t position();
    void seek(uint64_t position);

    /// Makes the file visible under its name, replacing what was there.
    void commit();

  private:
    [[noreturn]] void fail(int error);
    void checkReplaceable(unsigned mode, unsigned owner) const;
    void makeTemporary();

    std::string path_;  ///< as the user gave it, for messages
    std::string target_;
    std::string temporary_;  ///< empty once renamed
    int slot_ = -1;          ///< in the table of pending temporaries
    int file_ = -1;
    int error_ = 0;  ///< errno of the first failure
};

/// Environment error unless a file can be created at `path`; leaves nothing behind, and removes
/// what killed processes left in that folder: files of the names that AtomicFile gives its
/// temporaries, which no process holds. Asked before long work, so that its result is not lost.
void checkWritable(const std::string& path);

/// Whether two names lead to one file, links of both kinds followed, whether or not it exists.
bool isSameFile(const std::string& a, const std::string& b);

/// Removes the temporaries of all AtomicFiles in flight. Async-signal-safe: for a handler that is
/// about to end the process.
void removePendingTemporaries() noexcept;

}  // namespace sheen
