// What a long job has gathered, kept in a file as it goes: begun again after it was interrupted,
// the job asks in the same order, and goes on where it stopped.
#pragma once

#include <cstdint>
#include <deque>
#include <fstream>
#include <memory>
#include <optional>
#include <string>

#include "gather/gatherer.h"

namespace sheen {

/// The file stays until remove(): whoever ends before has not finished.
class GatherLog {
  public:
    /// What the file holds is taken as far as it is whole, if a job of the same `key` wrote it;
    /// that of another is replaced, with a warning. Where the file cannot be written, or is of
    /// another kind, nothing is kept, with a warning.
    GatherLog(std::string path, const std::string& key);

    /// What was found where these were gathered, if that comes next; from the first on that does
    /// not, nothing does.
    std::optional<std::vector<GatheredRecord>> next(std::span<const RecordSite> sites);
    void add(std::span<const RecordSite> sites, std::span<const GatheredRecord> records);
    /// So many records came from the file.
    size_t reused() const { return reused_; }
    void remove();

  private:
    struct Entry {
        uint64_t sites;  // a hash of them
        std::string records;
    };
    bool read(const std::string& head);
    void writeAfterWhole();
    void stopWriting(const std::string& why);

    const std::string path_;
    std::deque<Entry> left_;
    std::ofstream out_;
    uint64_t whole_ = 0;  // of the file: bytes before what is left
    bool ours_ = false;   // the file
    size_t reused_ = 0;
};

/// Asks `own` for what the log lacks, which must outlive it.
std::unique_ptr<Gatherer> gatherByLog(std::unique_ptr<Gatherer> own, GatherLog& log);

}  // namespace sheen
