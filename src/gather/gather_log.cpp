#include "gather/gather_log.h"

#include <fmt/format.h>
#include <xxhash.h>

#include <filesystem>
#include <iterator>
#include <system_error>
#include <utility>
#include <vector>

#include "core/bytes.h"
#include "core/error.h"
#include "gather/gathered_bytes.h"
#include "image/atomic_file.h"

namespace sheen {
namespace {

// The file: this and a hash of the key, then entries: hash of the sites, length and hash of the
// records, records.
constexpr char kMagic[] = "sheen gathered 1\n";

uint64_t hashOf(const std::string& bytes) { return XXH3_64bits(bytes.data(), bytes.size()); }

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
    std::error_code error;
    const auto size = std::filesystem::file_size(path_, error);
    if (!error && size > 0 && !read(head)) {
        out_.setstate(std::ios::failbit);
        warn(
            fmt::format("{}: is no file of what was gathered, and is left as it is; interrupted, "
                        "this will begin anew",
                        path_));
        return;
    }
    try {
        AtomicFile whole(path_);
        whole.write(head);
        for (const Entry& entry : left_) {
            whole.write(bytesOf(entry));
        }
        whole.commit();
        out_.open(path_, std::ios::binary | std::ios::app);
    } catch (const Error&) {
        out_.setstate(std::ios::failbit);
    }
    if (!out_) {
        stopWriting();
    }
}

std::string GatherLog::bytesOf(const Entry& entry) {
    ByteWriter out;
    out.put(entry.sites);
    out.put(hashOf(entry.records));
    out.put(entry.records);
    return out.bytes();
}

// Whether it is such a file.
bool GatherLog::read(const std::string& head) {
    std::ifstream in(path_, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(in), std::istreambuf_iterator<char>()};
    if (!bytes.starts_with(kMagic)) {
        return false;
    }
    if (!bytes.starts_with(head)) {
        warn(
            fmt::format("{}: is of another scene, other options or another version; it is begun "
                        "anew",
                        path_));
        return true;
    }
    constexpr size_t kNumbers = 3 * sizeof(uint64_t);
    for (size_t at = head.size(); bytes.size() - at >= kNumbers;) {
        ByteReader numbers(std::string_view(bytes).substr(at, kNumbers));
        const auto sites = numbers.get<uint64_t>();
        const auto hash = numbers.get<uint64_t>();
        const auto length = numbers.get<uint64_t>();
        at += kNumbers;
        if (length > bytes.size() - at) {
            break;
        }
        std::string records = bytes.substr(at, length);
        if (hashOf(records) != hash) {
            break;
        }
        at += length;
        left_.push_back({sites, std::move(records)});
    }
    return true;
}

void GatherLog::stopWriting() {
    warn(fmt::format("{}: cannot be written; interrupted, this will begin anew", path_));
    out_.close();
    out_.setstate(std::ios::failbit);
}

std::optional<std::vector<GatheredRecord>> GatherLog::next(std::span<const RecordSite> sites) {
    if (left_.empty()) {
        return std::nullopt;
    }
    if (left_.front().sites != hashOf(sites)) {
        left_.clear();
        return std::nullopt;
    }
    std::vector<GatheredRecord> records = recordsOf(left_.front().records);
    SHEEN_CHECK_EQ(records.size(), sites.size());
    left_.pop_front();
    reused_ += records.size();
    return records;
}

void GatherLog::add(std::span<const RecordSite> sites, std::span<const GatheredRecord> records) {
    if (!out_) {
        return;
    }
    if (!(out_ << bytesOf(Entry{hashOf(sites), sheen::bytesOf(records)}) << std::flush)) {
        stopWriting();
    }
}

void GatherLog::remove() {
    out_.close();
    std::error_code error;
    std::filesystem::remove(path_, error);
}

std::unique_ptr<Gatherer> gatherByLog(std::unique_ptr<Gatherer> own, GatherLog& log) {
    return std::make_unique<LoggedGatherer>(std::move(own), log);
}

}  // namespace sheen
