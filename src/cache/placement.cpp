#include "cache/placement.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "cache/record_tree.h"
#include "core/error.h"
#include "core/progress.h"
#include "core/timer.h"
#include "receivers/creases.h"
#include "receivers/predicted.h"
#include "receivers/served.h"

namespace sheen {
namespace {

// Weights are summed in fixed point, so that taking a record's weights back is exact and the sum
// does not depend on the order of summation.
constexpr float kWeightScale = 4096.0f;
constexpr float kWeightLimit = 64.0f;
const auto kCovered = static_cast<uint32_t>(shared::MIN_WEIGHT_SUM * kWeightScale);

// Records whose normals differ more are not compared.
constexpr float kSameSurfaceCosine = 0.95f;
// Relative difference of neighbours that the gathers' own resolution explains.
constexpr float kGatherNoise = 0.01f;

// So many records nearby tell a new one where to look closer.
constexpr size_t kNearest = 3;
constexpr size_t kNone = ~size_t{0};

// Texels that count in what a lobe sees: from so few on it is known, from so many on as well as
// what all of them say.
constexpr float kFewTexels = 8.0f;
constexpr float kEnoughTexels = 32.0f;

// Records that serve creases reach at most so much farther than the least, by which neighbours'
// footprints may differ.
constexpr float kCreaseReach = 1.1f;

float largestChange(const Record& r) {
    return luminance(
        {glm::length(r.translation_r), glm::length(r.translation_g), glm::length(r.translation_b)});
}

class Placer {
  public:
    Placer(const Scene& scene, const Receivers& receivers, const PlacementParams& params,
           Gatherer& gatherer, RecordField& field, double seconds)
        : scene_(scene),
          receivers_(receivers),
          params_(params),
          weight_(params.weight()),
          gatherer_(gatherer),
          field_(field),
          seconds_(seconds),
          creases_(findCreases(receivers)),
          sums_(receivers.positions.size()),
          unserved_(receivers.positions.size()),
          tree_(scene.bounds) {}

    Placement run(bool quiet);

  private:
    // What becomes of the field's record of the same index.
    struct Placed {
        Record record;
        int pixel = 0;
        float footprint = 0;
        float allowed = 0;   // radius that its light and its neighbours allow, below any bound
        float outgoing = 0;  // luminance toward the camera at its own pixel
    };

    const vec3& position(int i) const { return receivers_.positions[static_cast<size_t>(i)]; }
    const vec3& normal(int i) const { return receivers_.normals[static_cast<size_t>(i)]; }
    float footprint(int i) const { return receivers_.footprints[static_cast<size_t>(i)]; }
    int order(int i) const { return receivers_.orders[static_cast<size_t>(i)]; }
    bool uncovered(int i) const {
        return order(i) != kNoOrder && sums_[static_cast<size_t>(i)] <= kCovered;
    }
    bool missed(int i) const { return uncovered(i) && unserved_[static_cast<size_t>(i)] == 0; }

    float leastRadius(float pixel_footprint) const {
        return params_.min_pixels * pixel_footprint / params_.accuracy;
    }
    float greatestRadius(int i) const {
        const bool crease = creases_[static_cast<size_t>(i)] != 0;
        const float pixels = crease ? params_.min_pixels : params_.max_pixels;
        return pixels * footprint(i) / params_.accuracy;
    }
    // A crease counts as served only by records that reach hardly farther than the least.
    bool mayServe(const Record& record, size_t i) const {
        return creases_[i] == 0 ||
               record.radius <= kCreaseReach * greatestRadius(static_cast<int>(i));
    }
    // The pixel after i on the grid of every stride-th pixel of every stride-th row.
    int nextPixel(int i, int stride) const {
        const int width = receivers_.image.width;
        const int x = i % width + stride;
        return x < width ? i + stride : (i / width + stride) * width;
    }

    using Nearest = std::array<size_t, kNearest>;  // placed records, kNone where there are fewer
    struct Choice {
        int pixel;
        Nearest nearest;
        float radius;  // predicted
    };
    Nearest nearestTo(const vec3& p) const;
    float predictedRadius(int pixel, size_t nearest) const;
    RecordSite siteOf(const Choice& choice, bool first) const;
    std::vector<Choice> chooseSites(int pixel, int stride) const;
    void place(const std::vector<Choice>& choices, bool first);
    void add(size_t index);
    float allowedRadius(const GatheredRecord& g, float footprint) const;
    float servingRadius(const Placed& placed) const;
    float splitSphereRadius(const GatheredRecord& g) const;
    float hessianRadius(const GatheredRecord& g, float image_height) const;
    void setMissed(size_t placed);
    float predictedOutgoing(size_t placed, int pixel) const;
    void heedNeighbours(size_t added);
    void limitRadius(size_t placed, float radius);
    void clampNeighbours(size_t added);
    void splat(const Record& record, bool add);
    void handOver(size_t placed, RecordCache& cache) const;

    const Scene& scene_;
    const Receivers& receivers_;
    const PlacementParams& params_;
    const WeightParams weight_;
    Gatherer& gatherer_;
    RecordField& field_;
    const double seconds_;
    const Timer timer_;
    const std::vector<uint8_t> creases_;
    std::vector<uint32_t> sums_;
    std::vector<uint8_t> unserved_;  // pixels that not even a record of their own serves
    std::vector<Placed> placed_;
    RecordTree tree_;
};

Placer::Nearest Placer::nearestTo(const vec3& p) const {
    Nearest nearest;
    nearest.fill(kNone);
    std::array<float, kNearest> distances;
    distances.fill(kInfinity);
    const auto may_be_nearer = [&](float distance2, float) {
        return distance2 <= distances.back();
    };
    tree_.visit(p, may_be_nearer, [&](size_t j) {
        const vec3 d = placed_[j].record.position - p;
        std::pair candidate(glm::dot(d, d), j);
        for (size_t k = 0; k < kNearest; ++k) {
            if (candidate < std::pair(distances[k], nearest[k])) {
                std::swap(candidate.first, distances[k]);
                std::swap(candidate.second, nearest[k]);
            }
        }
    });
    return nearest;
}

RecordSite Placer::siteOf(const Choice& choice, bool first) const {
    const int pixel = choice.pixel;
    RecordSite site = siteAt(scene_, receivers_, static_cast<size_t>(pixel));
    // Of the first nothing is known.
    site.reach = first ? 0.0f : choice.radius * params_.accuracy / footprint(pixel);
    site.first = first;
    for (size_t j : choice.nearest) {
        if (j != kNone) {
            const std::vector<Contrast>& found = field_.records[j].contrasts;
            site.contrasts.insert(site.contrasts.end(), found.begin(), found.end());
        }
    }
    return site;
}

// The radius a record at a pixel will most likely have: that of the nearest one placed so far,
// since neighbours on a surface have similar ones, within bounds.
float Placer::predictedRadius(int pixel, size_t nearest) const {
    return std::clamp(nearest == kNone ? kInfinity : placed_[nearest].record.radius,
                      leastRadius(footprint(pixel)), greatestRadius(pixel));
}

// The next sites, from `pixel` on: pixels that are missed and that no site chosen before them is
// predicted to serve.
std::vector<Placer::Choice> Placer::chooseSites(int pixel, int stride) const {
    struct Chosen {
        vec3 position, normal;
        float radius;
        int order;
    };
    std::vector<Chosen> chosen;
    std::vector<Choice> choices;
    const int count = receivers_.count();
    for (int i = pixel; i < count && static_cast<int>(choices.size()) < params_.batch;
         i = nextPixel(i, stride)) {
        if (!missed(i)) {
            continue;
        }
        const vec3 p = position(i);
        const vec3 n = normal(i);
        const bool served = std::any_of(chosen.begin(), chosen.end(), [&](const Chosen& k) {
            return serves(k.order, order(i)) &&
                   shared::recordWeight(weight_, k.position, k.normal, k.radius, p, n,
                                        footprint(i)) > shared::MIN_WEIGHT_SUM;
        });
        if (!served) {
            const Nearest nearest = nearestTo(p);
            choices.push_back({i, nearest, predictedRadius(i, nearest[0])});
            chosen.push_back({p, n, choices.back().radius, order(i)});
        }
    }
    return choices;
}

// Gathers where chosen, all at once, and places the records in order.
void Placer::place(const std::vector<Choice>& choices, bool first) {
    std::vector<RecordSite> sites;
    for (const Choice& choice : choices) {
        sites.push_back(siteOf(choice, first));
    }
    if (timer_.seconds() > seconds_) {
        throw OutOfTime{};
    }
    std::vector<GatheredRecord> gathered = gatherer_.gather(sites);
    SHEEN_CHECK_EQ(gathered.size(), sites.size());
    for (size_t i = 0; i < choices.size(); ++i) {
        field_.records.push_back(std::move(gathered[i]));
        field_.pixels.push_back(choices[i].pixel);
        add(field_.records.size() - 1);
    }
}

// Places the field's next record.
void Placer::add(size_t index) {
    const GatheredRecord& g = field_.records[index];
    const int pixel = field_.pixels[index];
    placed_.push_back({g.record, pixel, footprint(pixel), allowedRadius(g, footprint(pixel))});
    Placed& placed = placed_.back();
    Record& record = placed.record;
    record.radius =
        std::clamp(placed.allowed, leastRadius(placed.footprint), greatestRadius(pixel));
    record.material = static_cast<float>(receivers_.materials[static_cast<size_t>(pixel)]);
    setMissed(index);
    placed.outgoing = predictedOutgoing(index, pixel);
    heedNeighbours(index);
    clampNeighbours(index);
    tree_.insert(record.position, record.radius);
    splat(record, true);
    // Its own pixel is served, whatever its radius, where numbers are sound: else the scan would
    // come back for ever.
    unserved_[static_cast<size_t>(pixel)] = missed(pixel) ? 1 : 0;
}

// The radius that the error control asks for.
float Placer::allowedRadius(const GatheredRecord& g, float footprint) const {
    switch (params_.control) {
        case ErrorControl::kSplitSphere:
            return splitSphereRadius(g);
        case ErrorControl::kHessian:
            return hessianRadius(g, footprint * static_cast<float>(receivers_.image.height));
    }
    throw std::logic_error("unknown error control");
}

// By the serving weight, which reaches farther than the one that records are placed by. Where light
// changes within a pixel, at contacts and beside thin ledges, the least reach is more than it
// allows already: there a record serves no farther than it was placed for, or each pixel would take
// half of its light from its neighbours. (Where the least reach is several pixels, they have no
// records of their own that would be better.)
float Placer::servingRadius(const Placed& placed) const {
    const float radius = placed.record.radius;
    if (params_.min_pixels > 1.0f) {
        return radius;
    }
    const float least = radius / params_.overlap;
    const bool crease = creases_[static_cast<size_t>(placed.pixel)] != 0;
    return crease ? least : std::clamp(placed.allowed, least, radius);
}

// Harmonic mean distance, limited by the relative change of irradiance. [WRC88]
float Placer::splitSphereRadius(const GatheredRecord& g) const {
    const float change = largestChange(g.record);
    return change > 0.0f ? std::min(g.record.radius, luminance(g.record.irradiance) / change)
                         : g.record.radius;
}

// With gradients, extrapolation over d errs by c d^2 / 2, where c is the second derivative,
// relative to the irradiance [SJJ12]. What is to be made small for a given number of records is the
// sum of squared errors over the image, c^2 d^4 / 4, against 1 / d^2 records an area: at the
// least, c d^3 is the same everywhere, in heights of the image: of how many pixels it is made does
// not change how wrong it is. [SJJ12] makes each record's total the same, c d^4; pointwise c d^2
// would be (docs/decisions.md compares them).
// It is not believed farther than the harmonic mean distance of what the record sees, over which
// all of that changes: what the record missed, or saw from a wrong place, has no curvature.
float Placer::hessianRadius(const GatheredRecord& g, float image_height) const {
    float reach = g.record.radius;
    if (g.curvature > 0.0f) {
        const float relative = g.curvature / luminance(g.record.irradiance);
        const float tolerated = 2.0f * params_.curvature * params_.accuracy;
        reach = std::min(reach, std::cbrt(tolerated * image_height / relative));
    }
    return reach / params_.accuracy;
}

// What the lobe of the record's own pixel sees more than the record says by its coefficients, or,
// of the diffuse class, by its irradiance.
void Placer::setMissed(size_t placed) {
    const GatheredRecord& g = field_.records[placed];
    if (!(g.lobe_texels > 0.0f)) {
        return;
    }
    const vec3 said =
        lobeLight(receivers_, g.record, g.sh.data(), static_cast<size_t>(placed_[placed].pixel));
    const float resolved = glm::smoothstep(kFewTexels, kEnoughTexels, g.lobe_texels);
    const vec3 missed = resolved * (g.lobe_light - said);
    Record& record = placed_[placed].record;
    record.missed_r = missed.x;
    record.missed_g = missed.y;
    record.missed_b = missed.z;
}

float Placer::predictedOutgoing(size_t placed, int pixel) const {
    return outgoingLuminance(receivers_, placed_[placed].record, field_.records[placed].sh.data(),
                             static_cast<size_t>(pixel));
}

// Shrinks a placed record's radius to `radius`, if that is smaller, and takes its weights along.
void Placer::limitRadius(size_t placed, float radius) {
    Record& record = placed_[placed].record;
    placed_[placed].allowed = std::min(placed_[placed].allowed, radius);
    const float limit = std::max(radius, leastRadius(placed_[placed].footprint));
    if (limit < record.radius) {
        splat(record, false);
        record.radius = limit;
        splat(record, true);
    }
}

// Records whose regions overlap predict each other through the BRDF of the pixels they serve. The
// error of an extrapolation with gradients grows with the square of the distance: from the error at
// the neighbour follows where it reaches the tolerated one, and the reach ends there. Of those that
// only meet where they serve, the placed reach stays as it is: what separates them, such as a
// ledge, leaves each its side. Based on: [KBPZ06], which shrinks by a fixed factor instead.
void Placer::heedNeighbours(size_t added) {
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
            glm::dot(record.normal, neighbour.normal) < kSameSurfaceCosine ||
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
            const float of_fresh = allowed(predictedOutgoing(added, other.pixel), other.outgoing);
            const float of_other = allowed(predictedOutgoing(j, fresh.pixel), fresh.outgoing);
            fresh.allowed = std::min(fresh.allowed, of_fresh);
            placed_[j].allowed = std::min(other.allowed, of_other);
            if (meet) {
                record.radius =
                    std::max(std::min(record.radius, of_fresh), leastRadius(fresh.footprint));
                limitRadius(j, of_other);
            }
        }
    }
}

// A feature that one record sees cannot be far from its neighbours: their reaches differ by at most
// the way between them, a R_i <= a R_j + |p_i - p_j|, for the new record against all and for all
// against the new one. [KBPZ06, 4.3] has R itself for the reach, which Ward's a multiplies.
void Placer::clampNeighbours(size_t added) {
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
    fresh.radius = std::max(fresh.radius, leastRadius(placed_[added].footprint));
    tree_.visit(
        fresh.position,
        [&](float distance2, float greatest) {
            const float beyond = a * (greatest - fresh.radius);
            return beyond > 0.0f && distance2 < beyond * beyond;
        },
        [&](size_t j) { limitRadius(j, fresh.radius + way(j)); });
}

void Placer::splat(const Record& record, bool add) {
    const auto may_serve = [&](size_t pixel) { return mayServe(record, pixel); };
    forServed(receivers_, record, weight_, may_serve, [&](size_t pixel, float v) {
        const auto fixed = static_cast<uint32_t>(std::min(v, kWeightLimit) * kWeightScale + 0.5f);
        uint32_t& sum = sums_[pixel];
        sum = add ? sum + fixed : sum - fixed;
    });
}

Placement Placer::run(bool quiet) {
    const int count = receivers_.count();
    const bool anew = field_.records.empty();
    for (size_t i = 0; i < field_.records.size(); ++i) {
        add(i);
    }
    // Clamping a neighbour may uncover pixels behind the scan, so the last grid, all pixels, is
    // scanned until nothing is missed. Every record keeps serving its own pixel, or that counts as
    // unserved, so this ends.
    for (int stride = params_.coarsest_stride; stride >= 1; stride /= 2) {
        Progress progress(stride == 1
                              ? "placing records, at every pixel"
                              : fmt::format("placing records, on a grid of {} pixels", stride),
                          count, quiet);
        bool placed_any = true;
        int passed = 0;
        while (placed_any) {
            placed_any = false;
            for (int i = 0; i < count; i = nextPixel(i, stride)) {
                if (missed(i)) {
                    progress.advance(std::max(i - passed, 0));
                    passed = std::max(passed, i);
                    place(chooseSites(i, stride), anew && stride == params_.coarsest_stride);
                    placed_any = stride == 1;
                }
            }
        }
    }
    Placement result;
    for (int i = 0; i < count; ++i) {
        result.uncovered += uncovered(i) ? 1 : 0;
    }
    for (size_t j = 0; j < placed_.size(); ++j) {
        handOver(j, result.cache);
    }
    return result;
}

// Appends a placed record with the radius it serves with, and bounds its gradients against that.
void Placer::handOver(size_t placed, RecordCache& cache) const {
    Record r = placed_[placed].record;
    r.radius = servingRadius(placed_[placed]);
    r.sh_first = static_cast<int>(cache.sh.size());
    const std::vector<float>& found = field_.records[placed].sh;
    cache.sh.insert(cache.sh.end(), found.begin(), found.end());
    boundGradients(r, cache.sh.data() + r.sh_first, params_.servingWeight().accuracy * r.radius,
                   params_.gradient_limit);
    cache.records.push_back(r);
}

}  // namespace

Placement placeRecords(const Scene& scene, const Receivers& receivers,
                       const PlacementParams& params, Gatherer& gatherer, RecordField& field,
                       bool quiet, double seconds) {
    SHEEN_CHECK(params.accuracy > 0.0f && params.batch >= 1 && params.coarsest_stride >= 1);
    SHEEN_CHECK(params.overlap >= 1.0f);
    // Its own pixel, closer than half of which all is the same, is served.
    SHEEN_CHECK(params.min_pixels > 0.5f * (1.0f + shared::MIN_WEIGHT_SUM));
    SHEEN_CHECK(params.max_pixels >= params.min_pixels);
    SHEEN_CHECK_EQ(field.records.size(), field.pixels.size());
    return Placer(scene, receivers, params, gatherer, field, seconds).run(quiet);
}

}  // namespace sheen
