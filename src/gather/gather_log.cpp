#include "gather/gather_log.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <filesystem>
#include <system_error>
#include <utility>
#include <vector>

#include "core/bytes.h"
#include "core/error.h"
#include "gather/gathered_bytes.h"
#include "image/atomic_file.h"

namespace sheen {
namespace {

// The file: this and a hash of the key, then entries: hash of the sites, hash of that and the
// records, length of the records, records.
constexpr char kMagic[] = "sheen gathered 1\n";
constexpr size_t kNumbers = 3 * sizeof(uint64_t);

uint64_t hashOf(const std::string& bytes) { return XXH3_64bits(bytes.data(), bytes.size()); }

uint64_t hashOf(uint64_t sites, const std::string& records) {
    return XXH3_64bits_withSeed(records.data(), records.size(), sites);
}

// By what tells sites apart: other members may have bytes that mean nothing.
uint64_t hashOf(std::span<const RecordSite> sites) {
    ByteWriter out;
    for (const RecordSite& site : sites) {
        out.put(site.position);
        out.put(site.normal);
        out.put(site.seed);
        out.put(site.order);
        out.put(site.reach);
    }
    return hashOf(out.bytes());
}

std::string headOf(const std::string& key) {
    ByteWriter out;
    out.put(hashOf(key));
    return kMagic + out.bytes();
}

class LoggedGatherer : public Gatherer {
  public:
    LoggedGatherer(std::unique_ptr<Gatherer> own, GatherLog& log)
        : own_(std::move(own)), log_(log) {}

    std::vector<GatheredRecord> gather(std::span<const RecordSite> sites) override {
        if (std::optional<std::vector<GatheredRecord>> kept = log_.next(sites)) {
            return std::move(*kept);
        }
        std::vector<GatheredRecord> records = own_->gather(sites);
        seconds_ = own_->seconds();
        log_.add(sites, records);
        return records;
    }

  private:
    std::unique_ptr<Gatherer> own_;
    GatherLog& log_;
};

}  // namespace

GatherLog::GatherLog(std::string path, const std::string& key) : path_(std::move(path)) {
    const std::string head = headOf(key);
    try {
        if (!read(head)) {
            AtomicFile fresh(path_);
            fresh.write(head);
            fresh.commit();
            whole_ = head.size();
        }
        ours_ = true;
        writeAfterWhole();
    } catch (const Error& error) {
        stopWriting(error.what());
    }
}

// Whether it is of this job. What of it is whole is left_, from whole_ on.
bool GatherLog::read(const std::string& head) {
    std::error_code error;
    const auto size = std::filesystem::file_size(path_, error);
    if (error || size == 0) {
        return false;
    }
    std::ifstream in(path_, std::ios::binary);
    std::string begin(head.size(), '\0');
    in.read(begin.data(), static_cast<std::streamsize>(begin.size()));
    if (!begin.starts_with(kMagic)) {
        throwEnvironment("{}: is no file of what was gathered; remove or rename it", path_);
    }
    if (!in || begin != head) {
        warn(
            fmt::format("{}: is of another scene, other options or another version; it is begun "
                        "anew",
                        path_));
        return false;
    }
    whole_ = head.size();
    std::string numbers(kNumbers, '\0');
    for (uint64_t at = whole_; in.read(numbers.data(), kNumbers); at += kNumbers) {
        ByteReader reader(numbers);
        const auto sites = reader.get<uint64_t>();
        const auto hash = reader.get<uint64_t>();
        const auto length = reader.get<uint64_t>();
        if (length > size - at - kNumbers) {
            break;
        }
        std::string records(length, '\0');
        if (!in.read(records.data(), static_cast<std::streamsize>(length)) ||
            hashOf(sites, records) != hash) {
            break;
        }
        at += length;
        left_.push_back({sites, std::move(records)});
    }
    return true;
}

// What follows what was taken from the file is dropped, once it is not taken.
void GatherLog::writeAfterWhole() {
    uint64_t size = whole_;
    for (const Entry& entry : left_) {
        size += kNumbers + entry.records.size();
    }
    std::error_code error;
    std::filesystem::resize_file(path_, size, error);
    out_.open(path_, std::ios::binary | std::ios::app);
    if (error || !out_) {
        throwEnvironment("{}: cannot be written", path_);
    }
}

void GatherLog::stopWriting(const std::string& why) {
    warn(fmt::format("{}; interrupted, this will begin anew", why));
    out_.close();
    out_.setstate(std::ios::failbit);
}

std::optional<std::vector<GatheredRecord>> GatherLog::next(std::span<const RecordSite> sites) {
    if (left_.empty()) {
        return std::nullopt;
    }
    if (left_.front().sites != hashOf(sites)) {
        left_.clear();
        out_.close();
        try {
            writeAfterWhole();
        } catch (const Error& error) {
            stopWriting(error.what());
        }
        return std::nullopt;
    }
    const Entry entry = std::move(left_.front());
    left_.pop_front();
    std::vector<GatheredRecord> records = recordsOf(entry.records);
    SHEEN_CHECK_EQ(records.size(), sites.size());
    whole_ += kNumbers + entry.records.size();
    reused_ += records.size();
    return records;
}

void GatherLog::add(std::span<const RecordSite> sites, std::span<const GatheredRecord> records) {
    if (!out_) {
        return;
    }
    const uint64_t of_sites = hashOf(sites);
    const std::string found = bytesOf(records);
    ByteWriter bytes;
    bytes.put(of_sites);
    bytes.put(hashOf(of_sites, found));
    bytes.put(found);
    if (!(out_ << bytes.bytes() << std::flush)) {
        stopWriting(fmt::format("{}: cannot be written", path_));
    }
}

void GatherLog::remove() {
    out_.close();
    if (ours_) {
        std::error_code error;
        std::filesystem::remove(path_, error);
    }
}

std::unique_ptr<Gatherer> gatherByLog(std::unique_ptr<Gatherer> own, GatherLog& log) {
    return std::make_unique<LoggedGatherer>(std::move(own), log);
}

}  // namespace sheen
