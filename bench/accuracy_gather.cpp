#include "accuracy_gather.h"

#include <algorithm>

#include "core/parallel.h"
#include "rays/jitter.h"

namespace sheen::bench {
namespace {

constexpr size_t kNearest = 3;  // records that tell a new one where to look closer, as in a render

// What the nearest of the other records found.
std::vector<Contrast> contrastsNear(std::span<const GatheredRecord> records, size_t index) {
    std::vector<std::pair<float, size_t>> others;
    for (size_t j = 0; j < records.size(); ++j) {
        const vec3 d = records[j].record.position - records[index].record.position;
        if (j != index) {
            others.emplace_back(glm::dot(d, d), j);
        }
    }
    const size_t count = std::min(kNearest, others.size());
    std::partial_sort(others.begin(), others.begin() + static_cast<std::ptrdiff_t>(count),
                      others.end());
    std::vector<Contrast> contrasts;
    for (size_t k = 0; k < count; ++k) {
        const std::vector<Contrast>& found = records[others[k].second].contrasts;
        contrasts.insert(contrasts.end(), found.begin(), found.end());
    }
    return contrasts;
}

}  // namespace

std::vector<GatheredRecord> gatherInBatches(RayGatherer& gatherer,
                                            std::span<const RecordSite> sites) {
    std::vector<GatheredRecord> records;
    for (size_t first = 0; first < sites.size(); first += kBatch) {
        const size_t count = std::min(kBatch, sites.size() - first);
        for (GatheredRecord& g : gatherer.gather(sites.subspan(first, count))) {
            records.push_back(std::move(g));
        }
    }
    return records;
}

void tellContrasts(RayGatherer& gatherer, std::span<RecordSite> sites) {
    std::vector<RecordSite> others(sites.begin(), sites.end());
    for (RecordSite& site : others) {
        site.seed = pcgHash(site.seed);
    }
    const std::vector<GatheredRecord> before = gatherInBatches(gatherer, others);
    for (size_t i = 0; i < sites.size(); ++i) {
        sites[i].contrasts = contrastsNear(before, i);
    }
}

YardstickRecords gatherByYardstick(const RayScene& rays, std::span<const RecordSite> sites,
                                   const WardStrata& strata) {
    YardstickRecords found;
    found.irradiance.resize(sites.size());
    std::vector<Counters> counters(sites.size());
    const Lights lights(rays.scene());
    parallelFor(static_cast<int>(sites.size()), [&](int index) {
        const auto i = static_cast<size_t>(index);
        Surface p;
        p.position = sites[i].position;
        p.n_g = sites[i].geometric_normal;
        p.n = sites[i].normal;
        p.offset = sites[i].offset;
        found.irradiance[i] =
            gatherRecord(rays, lights, p, strata, static_cast<uint32_t>(index), counters[i])
                .irradiance;
    });
    for (const Counters& c : counters) {
        found.rays += c.rays;
    }
    return found;
}

}  // namespace sheen::bench
