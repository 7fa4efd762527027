#include "cache/temporal.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "gather/strata.h"
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

// By how much of itself a record's light differs from that, of as many coefficients.
float changeTo(const GatheredRecord& found, const vec3& irradiance, const std::vector<float>& sh) {
    const vec3& now = found.record.irradiance;
    const vec3 change = irradiance - now;
    double result = relative(normOf({&change[0], 3}), normOf({&now[0], 3}));
    if (!found.sh.empty()) {
        const auto of_now = valuesOf(found.sh, found.record.order);
        const auto of_later = valuesOf(sh, found.record.order);
        std::vector<float> changes(of_now.size());
        std::transform(of_later.begin(), of_later.end(), of_now.begin(), changes.begin(),
                       std::minus<>());
        result = std::max(result, relative(normOf(changes), normOf(of_now)));
    }
    return static_cast<float>(result);
}

bool moves(const Ageing& ageing, uint32_t triangle) {
    return triangle < ageing.moved.size() && ageing.moved[triangle] != 0;
}

// Light that has changed by so many times a_t since a record was gathered, and by no more than a_t
// the frame before, has jumped. Witnesses alone are too few to tell: one that meets an edge stands
// for a 32nd of the light. What was gathered tells with them.
constexpr float kJump = 3.0f;

// [record]: by how much of itself its light has changed since it was gathered, foreseen or not.
// Those of this frame, and of frames that differ by cameras alone, have age 0. Of those that end
// anyway it is asked whether light jumps.
std::vector<float> changesOf(const RecordField& field, const TemporalParams& params,
                             Gatherer& gatherer) {
    const bool of_ended = params.gradients == TemporalGradients::kInterpolated;
    std::vector<const GatheredRecord*> asked;
    std::vector<size_t> indices;
    for (size_t k = 0; k < field.records.size(); ++k) {
        const GatheredRecord& found = field.records[k];
        if (found.age > 0 && (of_ended || found.age < found.lifespan)) {
            asked.push_back(&found);
            indices.push_back(k);
        }
    }
    const std::vector<float> changes = gatherer.changesSince(asked);
    std::vector<float> result(field.records.size(), 0.0f);
    for (size_t n = 0; n < asked.size(); ++n) {
        result[indices[n]] = changes[n];
    }
    return result;
}

// Whether a record goes on as it is, or as its strata say.
bool goesOn(const Ageing& ageing, const GatheredRecord& found, bool moved, float change) {
    if (ageing.anchors) {
        return ageing.stands || (found.strata != nullptr && !moved);
    }
    return !moved && found.age < found.lifespan && change <= ageing.params.accuracy;
}

// Brings records with strata up to date, and tells them who looks at them now.
void followStrata(const Scene& scene, const Receivers& receivers, const Ageing& ageing,
                  Gatherer& gatherer, RecordField& field) {
    std::vector<GatheredRecord*> followed;
    for (size_t k = 0; k < field.records.size(); ++k) {
        GatheredRecord& found = field.records[k];
        const auto i = static_cast<size_t>(field.pixels[k]);
        if (!found.strata || !goesOn(ageing, found, moves(ageing, receivers.triangles[i]), 0.0f)) {
            continue;
        }
        RecordSite& site = found.strata->site;
        const RecordSite seen = siteAt(scene, receivers, i);
        const bool turned = seen.lobe.any() && seen.toward_viewer != site.toward_viewer;
        site.toward_viewer = seen.toward_viewer;
        site.lobe = seen.lobe;
        if (!ageing.stands || turned) {
            followed.push_back(&found);
        }
    }
    gatherer.follow(followed, ageing.stands);
}

// What mixing takes of a record.
GatheredRecord saidBy(const GatheredRecord& found) {
    GatheredRecord said = found;
    said.witnesses = {};
    said.later.reset();
    said.life.reset();
    return said;
}

// `found` was gathered in this frame.
void beginLife(GatheredRecord& found, const TemporalParams& params) {
    found.age = 0;
    found.lifespan = lifespanOf(found, params);
    if (params.gradients == TemporalGradients::kInterpolated) {
        found.life = std::make_shared<Life>(Life{.first = saidBy(found), .next = {}});
    }
}

// Mixes all of a record that may differ at its place.
template <class Mix>
void mixRecords(Record& now, const Record& then, const Mix& mix) {
    for (vec3 Record::*vector :
         {&Record::irradiance, &Record::rotation_r, &Record::rotation_g, &Record::rotation_b,
          &Record::translation_r, &Record::translation_g, &Record::translation_b}) {
        mix(now.*vector, then.*vector);
    }
    for (float Record::*number :
         {&Record::radius, &Record::missed_r, &Record::missed_g, &Record::missed_b}) {
        mix(now.*number, then.*number);
    }
}

}  // namespace

float changeOf(const GatheredRecord& found) {
    return found.later ? changeTo(found, found.later->irradiance, found.later->sh) : 0.0f;
}

int lifespanOf(const GatheredRecord& found, const TemporalParams& params) {
    const float change = changeOf(found);
    // The last frame n with change * n < a_t, and the frame 0.
    const float last = std::ceil(params.accuracy / change) - 1.0f;
    const auto longest = static_cast<float>(params.longest);
    return std::max(1, static_cast<int>(std::min(last + 1.0f, longest)));
}

void beginLives(RecordField& field, size_t first, const TemporalParams& params, bool spread) {
    // What differs at both ends of a line by chance should take its time.
    const int shortest =
        params.gradients == TemporalGradients::kInterpolated ? (params.longest + 1) / 2 : 1;
    const auto range = static_cast<uint32_t>(params.longest - shortest + 1);
    for (size_t i = first; i < field.records.size(); ++i) {
        GatheredRecord& found = field.records[i];
        beginLife(found, params);
        if (spread) {
            const vec3& p = found.record.position;
            uint32_t hash = 0;
            for (int c = 0; c < 3; ++c) {
                hash = pcgHash(hash ^ glm::floatBitsToUint(p[c]));
            }
            found.lifespan = std::min(found.lifespan, shortest + static_cast<int>(hash % range));
        }
    }
}

void endLife(const GatheredRecord& found, const GatheredRecord& next, float change,
             const TemporalParams& params) {
    if (!found.life) {
        return;
    }
    Life& life = *found.life;
    if (life.first.sh.size() == next.sh.size()) {
        const float gathered = changeTo(life.first, next.record.irradiance, next.sh);
        life.jumps = std::min(change, gathered) > kJump * params.accuracy;
        life.frames = found.age;
        life.next = saidBy(next);
        life.next->contrasts = {};
    }
}

GatheredRecord recordAt(const Life& life, int age) {
    GatheredRecord result = life.first;
    result.age = age;
    if (!life.next || life.jumps || age == 0) {
        return result;
    }
    const GatheredRecord& next = *life.next;
    const float t = static_cast<float>(age) / static_cast<float>(life.frames);
    const auto mix = [t](auto& now, const auto& then) { now = glm::mix(now, then, t); };
    mixRecords(result.record, next.record, mix);
    for (size_t k = 0; k < result.sh.size(); ++k) {
        mix(result.sh[k], next.sh[k]);
    }
    mix(result.curvature, next.curvature);
    mix(result.lobe_light, next.lobe_light);
    mix(result.lobe_texels, next.lobe_texels);
    return result;
}

void growOlder(GatheredRecord& found, const TemporalParams& params) {
    ++found.age;
    if (!found.later || params.gradients == TemporalGradients::kNone) {
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
    const TemporalParams& params = ageing.params;
    std::vector<float> changes(field.records.size());
    if (ageing.anchors) {
        followStrata(scene, receivers, ageing, gatherer, field);
    } else {
        changes = changesOf(field, params, gatherer);
    }
    std::vector<size_t> ended;
    std::vector<RecordSite> sites;
    for (size_t k = 0; k < field.records.size(); ++k) {
        const GatheredRecord& found = field.records[k];
        const auto i = static_cast<size_t>(field.pixels[k]);
        const bool moved = moves(ageing, receivers.triangles[i]);
        if (goesOn(ageing, found, moved, changes[k])) {
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
            const size_t k = ended[first + n];
            GatheredRecord& found = field.records[k];
            endLife(found, gathered[n], changes[k], params);
            found = std::move(gathered[n]);
            if (!ageing.anchors) {
                beginLife(found, params);
            }
        }
    }
    return ended.size();
}

}  // namespace sheen
