#include "gather/gathered_bytes.h"

#include <type_traits>

#include "core/bytes.h"

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

}  // namespace

std::string bytesOf(std::span<const RecordSite> sites) {
    ByteWriter out;
    for (const RecordSite& site : sites) {
        forMembersOfSite(site, writerTo(out));
    }
    return out.bytes();
}

std::vector<RecordSite> sitesOf(const std::string& bytes) {
    std::vector<RecordSite> sites;
    for (ByteReader in(bytes); !in.atEnd();) {
        forMembersOfSite(sites.emplace_back(), readerFrom(in));
    }
    return sites;
}

std::string bytesOf(std::span<const GatheredRecord> records) {
    ByteWriter out;
    for (const GatheredRecord& record : records) {
        forMembersOfRecord(record, writerTo(out));
    }
    return out.bytes();
}

std::vector<GatheredRecord> recordsOf(const std::string& bytes) {
    std::vector<GatheredRecord> records;
    for (ByteReader in(bytes); !in.atEnd();) {
        forMembersOfRecord(records.emplace_back(), readerFrom(in));
    }
    return records;
}

}  // namespace sheen
