#include "cache/temporal.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "rays/jitter.h"

namespace sheen {
namespace {

double normOf(std::span<const float> values) {
    return std::sqrt(std::inner_product(values.begin(), values.end(), values.begin(), 0.0));
}

double relative(double change, double of) {
    return change == 0.0 ? 0.0 : of > 0.0 ? change / of : kInfinity;
}

// The coefficients of a record's radiance, without those of its gradients.
std::span<const float> valuesOf(const std::vector<float>& sh, int order) {
    return std::span(sh).first(static_cast<size_t>(3 * order * order));
}

bool moves(const Ageing& ageing, uint32_t triangle) {
    return triangle < ageing.moved.size() && ageing.moved[triangle] != 0;
}

// [record]: whose light has changed by more than a life allows, foreseen or not. Those of this
// frame, and of frames that differ by cameras alone, have age 0.
std::vector<uint8_t> outdated(const RecordField& field, const TemporalParams& params,
                              Gatherer& gatherer) {
    std::vector<const GatheredRecord*> asked;
    std::vector<size_t> indices;
    for (size_t k = 0; k < field.records.size(); ++k) {
        const GatheredRecord& found = field.records[k];
        if (found.age > 0 && found.age < found.lifespan) {
            asked.push_back(&found);
            indices.push_back(k);
        }
    }
    const std::vector<float> changes = gatherer.changesSince(asked);
    std::vector<uint8_t> result(field.records.size(), 0);
    for (size_t n = 0; n < asked.size(); ++n) {
        result[indices[n]] = changes[n] > params.accuracy ? 1 : 0;
    }
    return result;
}

}  // namespace

float changeOf(const GatheredRecord& found) {
    if (!found.later) {
        return 0.0f;
    }
    const vec3& now = found.record.irradiance;
    const vec3 change = found.later->irradiance - now;
    double result = relative(normOf({&change[0], 3}), normOf({&now[0], 3}));
    if (!found.sh.empty()) {
        const auto of_now = valuesOf(found.sh, found.record.order);
        const auto of_later = valuesOf(found.later->sh, found.record.order);
        std::vector<float> changes(of_now.size());
        std::transform(of_later.begin(), of_later.end(), of_now.begin(), changes.begin(),
                       std::minus<>());
        result = std::max(result, relative(normOf(changes), normOf(of_now)));
    }
    return static_cast<float>(result);
}

int lifespanOf(const GatheredRecord& found, const TemporalParams& params) {
    const float change = changeOf(found);
    // The last frame n with change * n < a_t, and the frame 0.
    const float last = std::ceil(params.accuracy / change) - 1.0f;
    const auto longest = static_cast<float>(params.longest);
    return std::max(1, static_cast<int>(std::min(last + 1.0f, longest)));
}

void beginLives(RecordField& field, size_t first, const TemporalParams& params, bool spread) {
    for (size_t i = first; i < field.records.size(); ++i) {
        GatheredRecord& found = field.records[i];
        found.age = 0;
        found.lifespan = lifespanOf(found, params);
        if (spread) {
            const vec3& p = found.record.position;
            uint32_t hash = 0;
            for (int c = 0; c < 3; ++c) {
                hash = pcgHash(hash ^ glm::floatBitsToUint(p[c]));
            }
            found.lifespan = std::min(
                found.lifespan, 1 + static_cast<int>(hash % static_cast<uint32_t>(params.longest)));
        }
    }
}

void growOlder(GatheredRecord& found, const TemporalParams& params) {
    ++found.age;
    if (!found.later || !params.extrapolate) {
        return;
    }
    // `later` stays one frame ahead.
    const vec3 change = found.later->irradiance - found.record.irradiance;
    found.record.irradiance = glm::max(found.later->irradiance, vec3(0.0f));
    found.later->irradiance = found.record.irradiance + change;
    const auto count = static_cast<size_t>(3 * found.record.order * found.record.order);
    for (size_t k = 0; k < std::min(count, found.sh.size()); ++k) {
        const float step = found.later->sh[k] - found.sh[k];
        found.sh[k] = found.later->sh[k];
        found.later->sh[k] += step;
    }
}

size_t renew(const Scene& scene, const Receivers& receivers, const PlacementParams& placement,
             const Ageing& ageing, Gatherer& gatherer, RecordField& field) {
    const std::vector<uint8_t> wrong = outdated(field, ageing.params, gatherer);
    std::vector<size_t> ended;
    std::vector<RecordSite> sites;
    for (size_t k = 0; k < field.records.size(); ++k) {
        const GatheredRecord& found = field.records[k];
        const auto i = static_cast<size_t>(field.pixels[k]);
        const bool moved = moves(ageing, receivers.triangles[i]);
        if (!moved && found.age < found.lifespan && wrong[k] == 0) {
            continue;
        }
        RecordSite site = siteAt(scene, receivers, i);
        if (!moved) {
            site.position = found.record.position;
            site.normal = found.record.normal;
        }
        const float footprint = receivers.footprints[i];
        site.reach = std::clamp(
            allowedRadius(found, placement, receivers.height(i)) * placement.accuracy / footprint,
            placement.min_pixels, placement.max_pixels);
        // Not what it found itself: its rays are the same, and what they missed they would miss
        // again.
        addContrasts(field, nearestOf(field, site.position, k), site);
        ended.push_back(k);
        sites.push_back(std::move(site));
    }
    // In batches: what hemispheres see is held until all of one are seen.
    const auto batch = static_cast<size_t>(placement.batch);
    for (size_t first = 0; first < sites.size(); first += batch) {
        const size_t count = std::min(batch, sites.size() - first);
        std::vector<GatheredRecord> gathered =
            gatherer.gather(std::span(sites).subspan(first, count));
        for (size_t n = 0; n < count; ++n) {
            GatheredRecord& found = field.records[ended[first + n]];
            found = std::move(gathered[n]);
            found.age = 0;
            found.lifespan = lifespanOf(found, ageing.params);
        }
    }
    return ended.size();
}

}  // namespace sheen
