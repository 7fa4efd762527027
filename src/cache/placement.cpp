#include "cache/placement.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>
#include <utility>

#include "cache/creases.h"
#include "cache/record_tree.h"
#include "core/error.h"
#include "core/progress.h"

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
    Placer(const Scene& scene, const GBuffer& gbuffer, const PixelClasses& classes,
           const PixelLobes& lobes, const PlacementParams& params, const GatherFunction& gather)
        : scene_(scene),
          gbuffer_(gbuffer),
          classes_(classes),
          lobes_(lobes),
          params_(params),
          weight_(params.weight()),
          gather_(gather),
          creases_(findCreases(gbuffer)),
          sums_(gbuffer.width, gbuffer.height),
          unserved_(gbuffer.width, gbuffer.height),
          tree_(scene.bounds) {}

    Placement run(bool quiet);

  private:
    struct Placed {
        GatheredRecord gathered;
        int pixel = 0;
        float footprint = 0;
        float allowed = 0;   // radius that its light and its neighbours allow, below any bound
        float outgoing = 0;  // luminance toward the camera at its own pixel
    };

    vec3 position(int i) const { return vec3(gbuffer_.position.pixels[static_cast<size_t>(i)]); }
    vec3 normal(int i) const { return vec3(gbuffer_.normal.pixels[static_cast<size_t>(i)]); }
    float footprint(int i) const {
        return gbuffer_.position.pixels[static_cast<size_t>(i)].w * gbuffer_.pixel_angle;
    }
    int order(int i) const { return classes_.orders.pixels[static_cast<size_t>(i)]; }
    bool uncovered(int i) const {
        return order(i) != kNoOrder && sums_.pixels[static_cast<size_t>(i)] <= kCovered;
    }
    bool missed(int i) const {
        return uncovered(i) && unserved_.pixels[static_cast<size_t>(i)] == 0;
    }

    float leastRadius(float pixel_footprint) const {
        return params_.min_pixels * pixel_footprint / params_.accuracy;
    }
    float greatestRadius(int i) const {
        const bool crease = creases_.pixels[static_cast<size_t>(i)] != 0;
        const float pixels = crease ? params_.min_pixels : params_.max_pixels;
        return pixels * footprint(i) / params_.accuracy;
    }
    // A crease counts as served only by records that reach hardly farther than the least.
    bool mayServe(const Record& record, size_t i) const {
        return creases_.pixels[i] == 0 ||
               record.radius <= kCreaseReach * greatestRadius(static_cast<int>(i));
    }
    // The pixel after i on the grid of every stride-th pixel of every stride-th row.
    int nextPixel(int i, int stride) const {
        const int x = i % gbuffer_.width + stride;
        return x < gbuffer_.width ? i + stride : (i / gbuffer_.width + stride) * gbuffer_.width;
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
    float allowedRadius(const Placed& placed) const;
    float servingRadius(const Placed& placed) const;
    float splitSphereRadius(const GatheredRecord& g) const;
    float hessianRadius(const GatheredRecord& g, float image_height) const;
    void setMissed(GatheredRecord& g, int pixel) const;
    float predictedOutgoing(const GatheredRecord& g, int pixel) const;
    void heedNeighbours(size_t added);
    void limitRadius(size_t placed, float radius);
    void clampNeighbours(size_t added);
    void splat(const Record& record, bool add);

    const Scene& scene_;
    const GBuffer& gbuffer_;
    const PixelClasses& classes_;
    const PixelLobes& lobes_;
    const PlacementParams& params_;
    const WeightParams weight_;
    const GatherFunction& gather_;
    const Image<uint8_t> creases_;
    Image<uint32_t> sums_;
    Image<uint8_t> unserved_;  // pixels that not even a record of their own serves
    std::vector<Placed> placed_;
    RecordTree tree_;
    Placement result_;
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
        const vec3 d = placed_[j].gathered.record.position - p;
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
    RecordSite site = siteAt(scene_, gbuffer_, classes_, pixel);
    // Of the first nothing is known.
    site.reach = first ? 0.0f : choice.radius * params_.accuracy / footprint(pixel);
    site.first = first;
    for (size_t j : choice.nearest) {
        if (j != kNone) {
            const std::vector<Contrast>& found = placed_[j].gathered.contrasts;
            site.contrasts.insert(site.contrasts.end(), found.begin(), found.end());
        }
    }
    return site;
}

// The radius a record at a pixel will most likely have: that of the nearest one placed so far,
// since neighbours on a surface have similar ones, within bounds.
float Placer::predictedRadius(int pixel, size_t nearest) const {
    return std::clamp(nearest == kNone ? kInfinity : placed_[nearest].gathered.record.radius,
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
    const int count = gbuffer_.width * gbuffer_.height;
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
    std::vector<GatheredRecord> gathered = gather_(sites);
    SHEEN_CHECK_EQ(gathered.size(), sites.size());
    for (size_t i = 0; i < choices.size(); ++i) {
        const int pixel = choices[i].pixel;
        placed_.push_back({std::move(gathered[i]), pixel, footprint(pixel)});
        Record& record = placed_.back().gathered.record;
        placed_.back().allowed = allowedRadius(placed_.back());
        record.radius = std::clamp(placed_.back().allowed, leastRadius(footprint(pixel)),
                                   greatestRadius(pixel));
        record.material = static_cast<float>(classes_.materials.pixels[static_cast<size_t>(pixel)]);
        setMissed(placed_.back().gathered, pixel);
        placed_.back().outgoing = predictedOutgoing(placed_.back().gathered, pixel);
        heedNeighbours(placed_.size() - 1);
        clampNeighbours(placed_.size() - 1);
        tree_.insert(record.position, record.radius);
        splat(record, true);
        // Its own pixel is served, whatever its radius, where numbers are sound: else the scan
        // would come back for ever.
        unserved_.pixels[static_cast<size_t>(pixel)] = missed(pixel) ? 1 : 0;
    }
}

// The radius that the error control asks for.
float Placer::allowedRadius(const Placed& placed) const {
    switch (params_.control) {
        case ErrorControl::kSplitSphere:
            return splitSphereRadius(placed.gathered);
        case ErrorControl::kHessian:
            return hessianRadius(placed.gathered,
                                 placed.footprint * static_cast<float>(gbuffer_.height));
    }
    throw std::logic_error("unknown error control");
}

// By the serving weight, which reaches farther than the one that records are placed by. Where light
// changes within a pixel, at contacts and beside thin ledges, the least reach is more than it
// allows already: there a record serves no farther than it was placed for, or each pixel would take
// half of its light from its neighbours. (Where the least reach is several pixels, they have no
// records of their own that would be better.)
float Placer::servingRadius(const Placed& placed) const {
    const float radius = placed.gathered.record.radius;
    if (params_.min_pixels > 1.0f) {
        return radius;
    }
    const float least = radius / params_.overlap;
    const bool crease = creases_.pixels[static_cast<size_t>(placed.pixel)] != 0;
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
void Placer::setMissed(GatheredRecord& g, int pixel) const {
    if (!(g.lobe_texels > 0.0f)) {
        return;
    }
    const vec3 said = lobeLight(gbuffer_, classes_, lobes_, g.record, g.sh.data(), pixel);
    const float resolved = glm::smoothstep(kFewTexels, kEnoughTexels, g.lobe_texels);
    const vec3 missed = resolved * (g.lobe_light - said);
    g.record.missed_r = missed.x;
    g.record.missed_g = missed.y;
    g.record.missed_b = missed.z;
}

float Placer::predictedOutgoing(const GatheredRecord& g, int pixel) const {
    return outgoingLuminance(gbuffer_, classes_, lobes_, g.record, g.sh.data(), pixel);
}

// Shrinks a placed record's radius to `radius`, if that is smaller, and takes its weights along.
void Placer::limitRadius(size_t placed, float radius) {
    Record& record = placed_[placed].gathered.record;
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
    Record& record = fresh.gathered.record;
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
        const Record& neighbour = other.gathered.record;
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
            const float of_fresh =
                allowed(predictedOutgoing(fresh.gathered, other.pixel), other.outgoing);
            const float of_other =
                allowed(predictedOutgoing(other.gathered, fresh.pixel), fresh.outgoing);
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
    Record& fresh = placed_[added].gathered.record;
    const float a = params_.accuracy;
    const auto way = [&](size_t j) {
        return glm::length(fresh.position - placed_[j].gathered.record.position) / a;
    };
    tree_.visit(
        fresh.position,
        [&](float distance2, float) { return distance2 < a * a * fresh.radius * fresh.radius; },
        [&](size_t j) {
            fresh.radius = std::min(fresh.radius, placed_[j].gathered.record.radius + way(j));
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
    forServed(gbuffer_, classes_, record, weight_, may_serve, [&](size_t pixel, float v) {
        const auto fixed = static_cast<uint32_t>(std::min(v, kWeightLimit) * kWeightScale + 0.5f);
        uint32_t& sum = sums_.pixels[pixel];
        sum = add ? sum + fixed : sum - fixed;
    });
}

Placement Placer::run(bool quiet) {
    const int count = gbuffer_.width * gbuffer_.height;
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
                    place(chooseSites(i, stride), stride == params_.coarsest_stride);
                    placed_any = stride == 1;
                }
            }
        }
    }
    for (int i = 0; i < count; ++i) {
        result_.uncovered += uncovered(i) ? 1 : 0;
    }
    // Bound the gradients against the final radii: within its reach a record may change its value
    // by no more than a share of it.
    for (Placed& p : placed_) {
        Record& r = p.gathered.record;
        r.radius = servingRadius(p);
        const float reach = params_.servingWeight().accuracy * r.radius;
        vec3* translation[] = {&r.translation_r, &r.translation_g, &r.translation_b};
        const ShLayout layout = shLayout(r.order);
        for (int c = 0; c < 3; ++c) {
            const float length = glm::length(*translation[c]);
            const float limit = params_.gradient_limit * r.irradiance[c];
            if (length * reach > limit) {
                *translation[c] *= limit / (length * reach);
            }
            if (r.order == shared::DIFFUSE_ORDER) {
                continue;
            }
            float* first[2];
            for (int axis = 0; axis < 2; ++axis) {
                first[axis] = &p.gathered.sh[static_cast<size_t>(
                    layout.gradientFirst(axis) + c * layout.gradientCoefficients())];
            }
            const float value = p.gathered.sh[static_cast<size_t>(c * layout.coefficients())];
            const float change = std::hypot(*first[0], *first[1]) * reach;
            const float sh_limit = params_.gradient_limit * std::max(value, 0.0f);
            const float scale = change > sh_limit ? sh_limit / change : 1.0f;
            for (int axis = 0; axis < 2; ++axis) {
                for (int k = 0; k < layout.gradientCoefficients(); ++k) {
                    first[axis][k] *= scale;
                }
            }
        }
        r.sh_first = static_cast<int>(result_.cache.sh.size());
        result_.cache.sh.insert(result_.cache.sh.end(), p.gathered.sh.begin(), p.gathered.sh.end());
        result_.cache.records.push_back(r);
        result_.pixels.push_back(p.pixel);
        result_.contrasts.push_back(std::move(p.gathered.contrasts));
    }
    return std::move(result_);
}

}  // namespace

RecordSite siteAt(const Scene& scene, const GBuffer& gbuffer, const PixelClasses& classes,
                  int pixel) {
    const auto i = static_cast<size_t>(pixel);
    const RayCaster::Receiver p = gbuffer.receiverAt(scene, pixel);
    const vec4& normal = gbuffer.normal.pixels[i];
    RecordSite site{.position = p.position,
                    .normal = vec3(normal),
                    .geometric_normal = p.n_g,
                    .toward_viewer = p.toward_viewer,
                    .offset = p.offset,
                    .order = classes.orders.pixels[i]};
    if (!classes.irradiance_only && !classes.isTooGlossy(pixel)) {
        const vec3 f0(gbuffer.f0.pixels[i]);
        site.lobe = {.alpha = shared::alphaFromRoughness(normal.w),
                     .f0 = (f0.x + f0.y + f0.z) / 3.0f,
                     .f90 = gbuffer.diffuse.pixels[i].w};
    }
    return site;
}

Placement placeRecords(const Scene& scene, const GBuffer& gbuffer, const PixelClasses& classes,
                       const PixelLobes& lobes, const PlacementParams& params,
                       const GatherFunction& gather, bool quiet) {
    SHEEN_CHECK(params.accuracy > 0.0f && params.batch >= 1 && params.coarsest_stride >= 1);
    SHEEN_CHECK(params.overlap >= 1.0f);
    // Its own pixel, closer than half of which all is the same, is served.
    SHEEN_CHECK(params.min_pixels > 0.5f * (1.0f + shared::MIN_WEIGHT_SUM));
    SHEEN_CHECK(params.max_pixels >= params.min_pixels);
    return Placer(scene, gbuffer, classes, lobes, params, gather).run(quiet);
}

float outgoingLuminance(const GBuffer& gbuffer, const PixelClasses& classes,
                        const PixelLobes& lobes, const Record& record, const float* sh, int pixel) {
    const auto i = static_cast<size_t>(pixel);
    const vec3 p(gbuffer.position.pixels[i]);
    const vec3 irradiance = shared::recordIrradiance(record, p, vec3(gbuffer.normal.pixels[i]));
    const vec3 albedo = specularAlbedo(gbuffer, pixel);
    if (classes.irradiance_only || classes.isTooGlossy(pixel) || albedo == vec3(0.0f)) {
        return luminance(irradiance);
    }
    vec3 light = lobeLight(gbuffer, classes, lobes, record, sh, pixel);
    if (static_cast<int>(record.material) == classes.materials.pixels[i]) {
        light += shared::recordMissed(record);
    }
    return luminance(vec3(gbuffer.diffuse.pixels[i]) * irradiance / kPi +
                     albedo * glm::max(light, vec3(0.0f)));
}

vec3 lobeLight(const GBuffer& gbuffer, const PixelClasses& classes, const PixelLobes& lobes,
               const Record& record, const float* sh, int pixel) {
    const auto i = static_cast<size_t>(pixel);
    const vec3 p(gbuffer.position.pixels[i]);
    const int order = classes.orders.pixels[i];
    if (order == shared::DIFFUSE_ORDER) {
        return shared::recordIrradiance(record, p, vec3(gbuffer.normal.pixels[i])) / kPi;
    }
    const shared::ShVector lobe = lobes.at(pixel, order);
    return lobes.scale.pixels[i] * convolveRecord(record, sh, lobe.c, order, p) /
           glm::max(specularAlbedo(gbuffer, pixel), vec3(1e-12f));
}

PixelRect slabBounds(const View& view, int width, int height, const vec3& center, float radius,
                     const vec3& normal, float half_height) {
    // Double precision: where the sphere almost reaches the eye's plane the tangents are small
    // differences of large numbers.
    const glm::dvec3 d = glm::dvec3(center) - glm::dvec3(view.origin);
    const double r = radius;
    const double z_axis_length = glm::length(glm::dvec3(view.forward));
    const glm::dvec3 forward = glm::dvec3(view.forward) / z_axis_length;
    const double z = glm::dot(forward, d);
    if (z < -r) {
        return {};
    }
    // Per image axis: the two planes through the eye that touch the sphere, [MM13].
    const auto range = [&](const glm::dvec3& axis, int size, int& low, int& high) {
        const double scale = glm::length(axis) / z_axis_length;
        const glm::dvec3 aside = glm::normalize(axis);
        const double x = glm::dot(aside, d);
        const double tangent2 = x * x + z * z - r * r;
        low = 0;
        high = size;
        if (z <= 1.0001 * r || tangent2 <= 0.0) {
            return;  // the sphere reaches behind the eye's plane: no bound on this axis
        }
        const double root = r * std::sqrt(tangent2);
        const double denominator = z * z - r * r;
        // A plane through the eye, x = s z, has all of the slab on one side where the centre's
        // distance from it is at least the slab's support along the plane's normal (1, -s): a
        // disc's and half the height's.
        const double normal_x = glm::dot(glm::dvec3(normal), aside);
        const double normal_z = glm::dot(glm::dvec3(normal), forward);
        const auto outside = [&](double s, double sign) {
            const double along = normal_x - s * normal_z;
            const double support = r * std::sqrt(std::max(1.0 + s * s - along * along, 0.0)) +
                                   half_height * std::abs(along);
            return sign * (s * z - x) >= support;
        };
        // From the sphere's bound toward the centre, as long as the slab stays outside.
        const auto tightened = [&](double bound, double sign) {
            constexpr int kSteps = 5;
            double inner = x / z;
            for (int i = 0; i < kSteps && half_height < radius; ++i) {
                const double middle = 0.5 * (inner + bound);
                (outside(middle, sign) ? bound : inner) = middle;
            }
            return bound / scale;
        };
        const double s0 = tightened((x * z - root) / denominator, -1.0);
        const double s1 = tightened((x * z + root) / denominator, 1.0);
        const auto pixel = [size](double s) {
            return std::clamp((0.5 * s + 0.5) * size, -1.0, size + 1.0);
        };
        // A pixel counts where its centre may lie inside; one more on each side for rounding.
        low = std::clamp(static_cast<int>(std::floor(pixel(s0) - 0.5)), 0, size);
        high = std::clamp(static_cast<int>(std::ceil(pixel(s1) + 0.5)), 0, size);
    };
    PixelRect rect;
    range(view.right, width, rect.x0, rect.x1);
    range(view.up, height, rect.y0, rect.y1);
    if (rect.x0 >= rect.x1 || rect.y0 >= rect.y1) {
        return {};
    }
    return rect;
}

// recordWeight() is above 0 only where |d| / R + sqrt(k_n t) < a and |d.(n + n_k)| / 2 <= c a R,
// with t = 1 - n.n_k = |n - n_k|^2 / 2. Of d.n_k = d.(n + n_k) / 2 - d.(n - n_k) / 2 the second
// part is at most |d| sqrt(t / 2) < |d| (a - |d| / R) / sqrt(2 k_n), which is greatest in the
// middle of the reach.
PixelRect servedBounds(const GBuffer& gbuffer, const Record& record, const WeightParams& weight) {
    const float reach = weight.accuracy * record.radius;
    const float tilted = weight.accuracy * reach / (4.0f * std::sqrt(2.0f * weight.normal_weight));
    return slabBounds(gbuffer.view, gbuffer.width, gbuffer.height, record.position, reach,
                      record.normal, weight.slab * reach + tilted);
}

PixelRect reachedBounds(const GBuffer& gbuffer, const Record& record, const WeightParams& weight) {
    constexpr float kRounding = 1e-5f;  // of another compiler's recordWeight()
    const PixelRect served = servedBounds(gbuffer, record, weight);
    const float reach = (1.0f + kRounding) * weight.accuracy * record.radius;
    const auto reached = [&](int x, int y) {
        const vec3 d = vec3(gbuffer.position.at(x, y)) - record.position;
        return glm::dot(d, d) < reach * reach && gbuffer.seen(y * gbuffer.width + x);
    };
    PixelRect rect{served.x1, served.y1, served.x0, served.y0};
    for (int y = served.y0; y < served.y1; ++y) {
        int first = served.x0;
        while (first < served.x1 && !reached(first, y)) {
            ++first;
        }
        if (first == served.x1) {
            continue;
        }
        int end = served.x1;
        while (end > rect.x1 && !reached(end - 1, y)) {
            --end;
        }
        rect = {std::min(rect.x0, first), std::min(rect.y0, y), std::max(rect.x1, end), y + 1};
    }
    return rect.x0 < rect.x1 ? rect : PixelRect{};
}

}  // namespace sheen
