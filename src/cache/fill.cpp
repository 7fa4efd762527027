#include "cache/fill.h"

#include <utility>

#include "cache/kmeans.h"
#include "cache/scan.h"
#include "core/error.h"
#include "core/timer.h"

namespace sheen {
namespace {

RecordSite siteOf(const Scene& scene, const PlacedRecords& placed, const SiteChoice& choice) {
    const Receivers& receivers = placed.receivers();
    RecordSite site = siteAt(scene, receivers, choice.receiver);
    // Of the first nothing is known.
    site.reach = choice.first ? 0.0f
                              : choice.radius * placed.params().accuracy /
                                    receivers.footprints[choice.receiver];
    site.first = choice.first;
    addContrasts(placed.field(), choice.nearest, site);
    return site;
}

// Gathers at these sites, adds what was found to the field and places it.
void add(const Scene& scene, const std::vector<SiteChoice>& choices, PlacedRecords& placed,
         Gatherer& gatherer, RecordField& field) {
    SHEEN_CHECK(&placed.field() == &field);
    std::vector<RecordSite> sites;
    for (const SiteChoice& choice : choices) {
        sites.push_back(siteOf(scene, placed, choice));
    }
    std::vector<GatheredRecord> gathered = gatherer.gather(sites);
    SHEEN_CHECK_EQ(gathered.size(), sites.size());
    for (size_t k = 0; k < choices.size(); ++k) {
        field.records.push_back(std::move(gathered[k]));
        field.pixels.push_back(static_cast<int>(choices[k].receiver));
    }
    placed.placeNew();
}

}  // namespace

bool fillOnce(const Scene& scene, PlacedRecords& placed, SiteChooser& chooser, Gatherer& gatherer,
              RecordField& field) {
    const std::vector<SiteChoice> choices = chooser.next(placed);
    add(scene, choices, placed, gatherer, field);
    return !choices.empty();
}

void fill(const Scene& scene, PlacedRecords& placed, SiteChooser& chooser, Gatherer& gatherer,
          RecordField& field, double seconds) {
    const Timer timer;
    while (true) {
        const std::vector<SiteChoice> choices = chooser.next(placed);
        if (choices.empty()) {
            return;
        }
        if (timer.seconds() > seconds) {
            throw OutOfTime{};
        }
        add(scene, choices, placed, gatherer, field);
    }
}

Placement placeRecords(const Scene& scene, const Receivers& receivers,
                       const PlacementParams& params, Gatherer& gatherer, RecordField& field,
                       bool quiet, double seconds) {
    SHEEN_CHECK(params.accuracy > 0.0f && params.batch >= 1 && params.coarsest_stride >= 1);
    SHEEN_CHECK(params.overlap >= 1.0f);
    // Its own pixel, closer than half of which all is the same, is served.
    SHEEN_CHECK(params.min_pixels > 0.5f * (1.0f + shared::MIN_WEIGHT_SUM));
    SHEEN_CHECK(params.max_pixels >= params.min_pixels);
    SHEEN_CHECK_EQ(field.records.size(), field.pixels.size());
    const Timer timer;
    const bool anew = field.records.empty();
    PlacedRecords placed(scene, receivers, params, field);
    if (params.sites == SitesBy::kKMeans) {
        KMeans chooser(placed, quiet);
        fill(scene, placed, chooser, gatherer, field, seconds - timer.seconds());
        field.of_clusters += chooser.clusterCount();
    } else {
        Scan chooser(receivers, params, anew, quiet);
        fill(scene, placed, chooser, gatherer, field, seconds - timer.seconds());
    }
    return {.cache = placed.handOver(), .uncovered = placed.coverage().countUncovered()};
}

RecordCache recordsAt(const Scene& scene, const Receivers& receivers,
                      std::span<const size_t> wanted, const PlacementParams& params,
                      Gatherer& gatherer) {
    std::vector<RecordSite> sites;
    for (const size_t i : wanted) {
        sites.push_back(siteAt(scene, receivers, i));
    }
    RecordCache cache;
    const std::vector<GatheredRecord> gathered = gatherer.gather(sites);
    for (size_t k = 0; k < wanted.size(); ++k) {
        Record record = gathered[k].record;
        record.radius = params.min_pixels * receivers.footprints[wanted[k]] / params.accuracy;
        record.material = static_cast<float>(receivers.materials[wanted[k]]);
        record.sh_first = static_cast<int>(cache.sh.size());
        cache.sh.insert(cache.sh.end(), gathered[k].sh.begin(), gathered[k].sh.end());
        boundGradients(record, cache.sh.data() + record.sh_first,
                       params.servingWeight().accuracy * record.radius, params.gradient_limit);
        cache.records.push_back(record);
    }
    return cache;
}

}  // namespace sheen
