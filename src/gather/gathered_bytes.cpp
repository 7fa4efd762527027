#include "gather/gathered_bytes.h"

#include <type_traits>

#include "core/bytes.h"

namespace sheen {
namespace {

template <class T, class Kind>
concept Is = std::is_same_v<std::remove_const_t<T>, Kind>;

// Calls visit(member) for all that is told of a site, or of what was found there.
template <Is<RecordSite> Site, class Visit>
void forMembers(Site& site, const Visit& visit) {
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

template <Is<GatheredRecord> Found, class Visit>
void forMembers(Found& found, const Visit& visit) {
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

template <class T>
std::string write(std::span<const T> values) {
    ByteWriter out;
    for (const T& value : values) {
        forMembers(value, [&out](const auto& member) { out.put(member); });
    }
    return out.bytes();
}

template <class T>
std::vector<T> read(const std::string& bytes) {
    std::vector<T> values;
    for (ByteReader in(bytes); !in.atEnd();) {
        forMembers(values.emplace_back(), [&in](auto& member) {
            member = in.get<std::remove_reference_t<decltype(member)>>();
        });
    }
    return values;
}

}  // namespace

std::string bytesOf(std::span<const RecordSite> sites) { return write(sites); }
std::vector<RecordSite> sitesOf(const std::string& bytes) { return read<RecordSite>(bytes); }

std::string bytesOf(std::span<const GatheredRecord> records) { return write(records); }
std::vector<GatheredRecord> recordsOf(const std::string& bytes) {
    return read<GatheredRecord>(bytes);
}

}  // namespace sheen
