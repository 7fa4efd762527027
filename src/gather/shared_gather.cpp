#include "gather/shared_gather.h"

#include <algorithm>
#include <iterator>
#include <utility>

#include "core/bytes.h"
#include "core/timer.h"

namespace sheen {
namespace {

void put(ByteWriter& out, const RecordSite& site) {
    out.put(site.position);
    out.put(site.normal);
    out.put(site.geometric_normal);
    out.put(site.toward_viewer);
    out.put(site.offset);
    out.put(site.seed);
    out.put(site.order);
    out.put(site.lobe);
    out.put(site.reach);
    out.put(site.contrasts);
    out.put(site.first);
}

RecordSite siteFrom(ByteReader& in) {
    RecordSite site;
    site.position = in.get<vec3>();
    site.normal = in.get<vec3>();
    site.geometric_normal = in.get<vec3>();
    site.toward_viewer = in.get<vec3>();
    site.offset = in.get<float>();
    site.seed = in.get<uint32_t>();
    site.order = in.get<int>();
    site.lobe = in.get<SpecularLobe>();
    site.reach = in.get<float>();
    site.contrasts = in.get<std::vector<Contrast>>();
    site.first = in.get<bool>();
    return site;
}

void put(ByteWriter& out, const GatheredRecord& found) {
    SHEEN_CHECK(!found.later && found.witnesses.empty());
    out.put(found.record);
    out.put(found.toward_viewer);
    out.put(found.sh);
    out.put(found.curvature);
    out.put(found.lobe_light);
    out.put(found.lobe_texels);
    out.put(found.contrasts);
    out.put(found.eye);
}

GatheredRecord recordFrom(ByteReader& in) {
    GatheredRecord found;
    found.record = in.get<Record>();
    found.toward_viewer = in.get<vec3>();
    found.sh = in.get<std::vector<float>>();
    found.curvature = in.get<float>();
    found.lobe_light = in.get<vec3>();
    found.lobe_texels = in.get<float>();
    found.contrasts = in.get<std::vector<Contrast>>();
    found.eye = in.get<vec3>();
    return found;
}

// A unit: sites; the answer: their records.
std::string gatherUnit(Gatherer& own, const std::string& unit) {
    std::vector<RecordSite> sites;
    for (ByteReader in(unit); !in.atEnd();) {
        sites.push_back(siteFrom(in));
    }
    ByteWriter out;
    for (const GatheredRecord& found : own.gather(sites)) {
        put(out, found);
    }
    return out.bytes();
}

}  // namespace

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
            put(out, site);
        }
        units.push_back(out.bytes());
    }
    std::vector<GatheredRecord> records(sites.size());
    job_.ranks->share(
        job_.text, units, [this](const std::string& unit) { return gatherUnit(own_, unit); },
        [&](size_t unit, const std::string& answer) {
            size_t k = unit * of_unit;
            for (ByteReader in(answer); !in.atEnd(); ++k) {
                records.at(k) = recordFrom(in);
            }
        });
    seconds_.see += timer.seconds();
    return records;
}

void serveGather(Gatherer& own, const RankedJob& job) {
    job.ranks->serve(job.text, [&](const std::string& unit) { return gatherUnit(own, unit); });
}

}  // namespace sheen
