#include "gather/shared_gather.h"

#include <algorithm>
#include <utility>

#include "core/timer.h"
#include "gather/gathered_bytes.h"

namespace sheen {
namespace {

// A unit: sites; the answer: their records.
std::string gatherUnit(Gatherer& own, const std::string& unit) {
    return bytesOf(own.gather(sitesOf(unit)));
}

class SharedGatherer : public Gatherer {
  public:
    SharedGatherer(std::unique_ptr<Gatherer> own, const RankedJob& job)
        : own_(std::move(own)), job_(job) {}

    std::vector<GatheredRecord> gather(std::span<const RecordSite> sites) override;

  private:
    std::unique_ptr<Gatherer> own_;
    const RankedJob& job_;
};

std::vector<GatheredRecord> SharedGatherer::gather(std::span<const RecordSite> sites) {
    constexpr size_t kUnitsOfARank = 2;  // so that no one waits long for the slowest
    const Timer timer;
    const size_t units_wanted = kUnitsOfARank * static_cast<size_t>(job_.ranks->count());
    const size_t of_unit = std::max<size_t>(1, (sites.size() + units_wanted - 1) / units_wanted);
    std::vector<std::string> units;
    for (size_t first = 0; first < sites.size(); first += of_unit) {
        units.push_back(bytesOf(sites.subspan(first, std::min(of_unit, sites.size() - first))));
    }
    std::vector<GatheredRecord> records(sites.size());
    job_.ranks->share(
        job_.text, units, [this](const std::string& unit) { return gatherUnit(*own_, unit); },
        [&](size_t unit, const std::string& answer) {
            std::vector<GatheredRecord> found = recordsOf(answer);
            std::move(found.begin(), found.end(),
                      records.begin() + static_cast<std::ptrdiff_t>(unit * of_unit));
        });
    seconds_.see += timer.seconds();
    return records;
}

}  // namespace

std::unique_ptr<Gatherer> gatherByAll(std::unique_ptr<Gatherer> own, const RankedJob& job,
                                      const std::function<std::string()>& told) {
    if (!job.isShared()) {
        return own;
    }
    job.ranks->tell(told());
    return std::make_unique<SharedGatherer>(std::move(own), job);
}

void serveGathers(const RankedJob& job, const MakeGatherer& make) {
    std::unique_ptr<Gatherer> own;
    job.ranks->serve(
        job.text, [&](const std::string& unit) { return gatherUnit(*own, unit); },
        [&](const std::string& told) {
            own.reset();
            own = make(told);
        });
}

}  // namespace sheen
