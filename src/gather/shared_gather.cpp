#include "gather/shared_gather.h"

#include <algorithm>
#include <type_traits>
#include <utility>

#include "core/bytes.h"
#include "core/timer.h"

namespace sheen {
namespace {

// Calls visit(member) for all that ranks tell each other of a site, or of what was found there.
template <class Site, class Visit>
void forMembersOfSite(Site& site, const Visit& visit) {
    visit(site.position);
    visit(site.normal);
    visit(site.geometric_normal);
    visit(site.toward_viewer);
    visit(site.offset);
    visit(site.seed);
    visit(site.order);
    visit(site.lobe);
    visit(site.reach);
    visit(site.contrasts);
    visit(site.first);
}

template <class Found, class Visit>
void forMembersOfRecord(Found& found, const Visit& visit) {
    SHEEN_CHECK(!found.later && found.witnesses.empty());
    visit(found.record);
    visit(found.toward_viewer);
    visit(found.sh);
    visit(found.curvature);
    visit(found.lobe_light);
    visit(found.lobe_texels);
    visit(found.contrasts);
    visit(found.eye);
}

auto writerTo(ByteWriter& out) {
    return [&out](const auto& member) { out.put(member); };
}

auto readerFrom(ByteReader& in) {
    return [&in](auto& member) { member = in.get<std::remove_reference_t<decltype(member)>>(); };
}

// A unit: sites; the answer: their records.
std::string gatherUnit(Gatherer& own, const std::string& unit) {
    std::vector<RecordSite> sites;
    for (ByteReader in(unit); !in.atEnd();) {
        forMembersOfSite(sites.emplace_back(), readerFrom(in));
    }
    ByteWriter out;
    for (const GatheredRecord& found : own.gather(sites)) {
        forMembersOfRecord(found, writerTo(out));
    }
    return out.bytes();
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
        ByteWriter out;
        for (const RecordSite& site :
             sites.subspan(first, std::min(of_unit, sites.size() - first))) {
            forMembersOfSite(site, writerTo(out));
        }
        units.push_back(out.bytes());
    }
    std::vector<GatheredRecord> records(sites.size());
    job_.ranks->share(
        job_.text, units, [this](const std::string& unit) { return gatherUnit(*own_, unit); },
        [&](size_t unit, const std::string& answer) {
            size_t k = unit * of_unit;
            for (ByteReader in(answer); !in.atEnd(); ++k) {
                forMembersOfRecord(records.at(k), readerFrom(in));
            }
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
