#include "cache/placed_records.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "receivers/predicted.h"

namespace sheen {
namespace {

// Records whose normals differ more are not compared.
constexpr float kComparedCosine = 0.95f;
// Relative difference of neighbours that the gathers' own resolution explains.
constexpr float kGatherNoise = 0.01f;

// Texels that count in what a lobe sees: from so few on it is known, from so many on as well as
// what all of them say.
constexpr float kFewTexels = 8.0f;
constexpr float kEnoughTexels = 32.0f;

}  // namespace

PlacedRecords::PlacedRecords(const Scene& scene, const Receivers& receivers,
                             const PlacementParams& params, const RecordField& field)
    : receivers_(receivers),
      params_(params),
      weight_(params.weight()),
      field_(field),
      bounds_(receivers, params),
      coverage_(receivers, bounds_, weight_),
      tree_(scene.bounds) {
    placeNew();
}

void PlacedRecords::placeNew() {
    for (size_t i = placed_.size(); i < field_.records.size(); ++i) {
        add(i);
    }
}

NearestRecords PlacedRecords::nearestTo(const vec3& p) const {
    NearestRecords nearest;
    nearest.fill(kNoRecord);
    std::array<float, kNearestRecords> distances;
    distances.fill(kInfinity);
    const auto may_be_nearer = [&](float distance2, float) {
        return distance2 <= distances.back();
    };
    tree_.visit(p, may_be_nearer, [&](size_t j) {
        const vec3 d = placed_[j].record.position - p;
        std::pair candidate(glm::dot(d, d), j);
        for (size_t k = 0; k < kNearestRecords; ++k) {
            if (candidate < std::pair(distances[k], nearest[k])) {
                std::swap(candidate.first, distances[k]);
                std::swap(candidate.second, nearest[k]);
            }
        }
    });
    return nearest;
}

float PlacedRecords::predictedRadius(size_t i, size_t nearest) const {
    return std::clamp(nearest == kNoRecord ? kInfinity : placed_[nearest].record.radius,
                      bounds_.least(receivers_.footprints[i]), bounds_.greatest(i));
}

void PlacedRecords::add(size_t index) {
    const GatheredRecord& g = field_.records[index];
    const auto i = static_cast<size_t>(field_.pixels[index]);
    const float footprint = receivers_.footprints[i];
    placed_.push_back({g.record, i, footprint, allowedRadius(g, params_, receivers_.height(i))});
    Placed& placed = placed_.back();
    Record& record = placed.record;
    record.radius = std::clamp(placed.allowed, bounds_.least(footprint), bounds_.greatest(i));
    record.material = static_cast<float>(receivers_.materials[i]);
    setMissed(index);
    placed.outgoing = predictedOutgoing(index, i);
    heedNeighbours(index);
    clampNeighbours(index);
    tree_.insert(record.position, record.radius);
    coverage_.add(record);
    if (index >= field_.reused) {  // gathered for this very receiver
        coverage_.giveUpIfMissed(i);
    }
}

// What the lobe of the record's own pixel sees more than the record says by its coefficients, or,
// of the diffuse class, by its irradiance.
void PlacedRecords::setMissed(size_t placed) {
    const GatheredRecord& g = field_.records[placed];
    if (!(g.lobe_texels > 0.0f)) {
        return;
    }
    const vec3 said = lobeLight(receivers_, g.record, g.sh.data(), placed_[placed].receiver);
    const float resolved = glm::smoothstep(kFewTexels, kEnoughTexels, g.lobe_texels);
    const vec3 missed = resolved * (g.lobe_light - said);
    Record& record = placed_[placed].record;
    record.missed_r = missed.x;
    record.missed_g = missed.y;
    record.missed_b = missed.z;
}

float PlacedRecords::predictedOutgoing(size_t placed, size_t i) const {
    return outgoingLuminance(receivers_, placed_[placed].record, field_.records[placed].sh.data(),
                             i);
}

// Shrinks a placed record's radius to `radius`, if that is smaller, and takes its weights along.
void PlacedRecords::limitRadius(size_t placed, float radius) {
    Record& record = placed_[placed].record;
    placed_[placed].allowed = std::min(placed_[placed].allowed, radius);
    const float limit = std::max(radius, bounds_.least(placed_[placed].footprint));
    if (limit < record.radius) {
        coverage_.remove(record);
        record.radius = limit;
        coverage_.add(record);
    }
}

// Records whose regions overlap predict each other through the BRDF of the pixels they serve. The
// error of an extrapolation with gradients grows with the square of the distance: from the error at
// the neighbour follows where it reaches the tolerated one, and the reach ends there. Of those that
// only meet where they serve, the placed reach stays as it is: what separates them, such as a
// ledge, leaves each its side. Based on: [KBPZ06], which shrinks by a fixed factor instead.
void PlacedRecords::heedNeighbours(size_t added) {
    if (params_.disagreement <= 0.0f) {
        return;
    }
    const float tolerated = params_.disagreement * params_.accuracy;
    Placed& fresh = placed_[added];
    Record& record = fresh.record;
    std::vector<size_t> near;
    const float radius = record.radius;
    // Whether they meet where they were placed for, and where they serve.
    const auto placed_reach = [&](float a, float b) { return params_.accuracy * (a + b); };
    const auto serving_reach = [&](float a, float b) {
        return std::max(placed_reach(a, b), params_.servingWeight().accuracy * std::max(a, b));
    };
    tree_.visit(
        record.position,
        [&](float distance2, float greatest) {
            const float reach = serving_reach(radius, greatest);
            return distance2 <= reach * reach;
        },
        [&](size_t j) { near.push_back(j); });
    std::sort(near.begin(), near.end());  // each shrinks the new record for those after it
    for (size_t j : near) {
        const Placed& other = placed_[j];
        const Record& neighbour = other.record;
        const vec3 d = record.position - neighbour.position;
        const float reach = placed_reach(record.radius, neighbour.radius);
        const float serving = serving_reach(record.radius, neighbour.radius);
        if (glm::dot(d, d) > serving * serving) {
            continue;
        }
        const bool meet = glm::dot(d, d) <= reach * reach;
        const float distance = glm::length(d);
        if (neighbour.order != record.order || distance == 0.0f ||
            glm::dot(record.normal, neighbour.normal) < kComparedCosine ||
            0.5f * std::abs(glm::dot(d, record.normal + neighbour.normal)) > weight_.slab * reach) {
            continue;
        }
        const float scale = std::max(fresh.outgoing, other.outgoing);
        const auto allowed = [&](float predicted, float actual) {
            const float error = std::abs(predicted - actual) / scale - kGatherNoise;
            return error > 0.0f ? distance * std::sqrt(tolerated / error) / params_.accuracy
                                : kInfinity;
        };
        if (scale > 0.0f) {
            const float of_fresh =
                allowed(predictedOutgoing(added, other.receiver), other.outgoing);
            const float of_other = allowed(predictedOutgoing(j, fresh.receiver), fresh.outgoing);
            fresh.allowed = std::min(fresh.allowed, of_fresh);
            placed_[j].allowed = std::min(other.allowed, of_other);
            if (meet) {
                record.radius =
                    std::max(std::min(record.radius, of_fresh), bounds_.least(fresh.footprint));
                limitRadius(j, of_other);
            }
        }
    }
}

// A feature that one record sees cannot be far from its neighbours: their reaches differ by at most
// the way between them, a R_i <= a R_j + |p_i - p_j|, for the new record against all and for all
// against the new one. [KBPZ06, 4.3] has R itself for the reach, which Ward's a multiplies.
void PlacedRecords::clampNeighbours(size_t added) {
    if (!params_.neighbour_clamping) {
        return;
    }
    Record& fresh = placed_[added].record;
    const float a = params_.accuracy;
    const auto way = [&](size_t j) {
        return glm::length(fresh.position - placed_[j].record.position) / a;
    };
    tree_.visit(
        fresh.position,
        [&](float distance2, float) { return distance2 < a * a * fresh.radius * fresh.radius; },
        [&](size_t j) {
            fresh.radius = std::min(fresh.radius, placed_[j].record.radius + way(j));
        });
    fresh.radius = std::max(fresh.radius, bounds_.least(placed_[added].footprint));
    tree_.visit(
        fresh.position,
        [&](float distance2, float greatest) {
            const float beyond = a * (greatest - fresh.radius);
            return beyond > 0.0f && distance2 < beyond * beyond;
        },
        [&](size_t j) { limitRadius(j, fresh.radius + way(j)); });
}

RecordCache PlacedRecords::handOver() const {
    RecordCache cache;
    for (size_t k = 0; k < placed_.size(); ++k) {
        const Placed& placed = placed_[k];
        Record r = placed.record;
        r.radius =
            servingRadius(r.radius, placed.allowed, bounds_.isCrease(placed.receiver), params_);
        r.sh_first = static_cast<int>(cache.sh.size());
        const std::vector<float>& found = field_.records[k].sh;
        cache.sh.insert(cache.sh.end(), found.begin(), found.end());
        boundGradients(r, cache.sh.data() + r.sh_first, params_.servingWeight().accuracy * r.radius,
                       params_.gradient_limit);
        cache.records.push_back(r);
    }
    return cache;
}

}  // namespace sheen
