#include "light/scattered_again.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "core/directions.h"
#include "core/parallel.h"
#include "light/place_elements.h"
#include "rays/jitter.h"
#include "scene/brdf_albedo.h"
#include "scene/ggx_sampling.h"

namespace sheen {
namespace {

// Rays of an element.
constexpr int kRows = 16, kColumns = 16;

// A way goes on from so many surfaces at most. The lobe of the last counts as if diffuse.
constexpr int kMostFollowed = 8;
// It goes on by chance, by so much more often than by the share of light that is reflected: the
// fewer ways, the more each counts, and the more noise there is.
constexpr float kOftener = 1.5f;

// Of a record's ray the lobe is followed in as many ways as it stands for that many steradians.
// Beside a glossy wall half of all rays meet it, where its lobe may see something small and bright
// in one of thirty ways, and records there, which serve few pixels, have few rays.
constexpr float kAngleOfWay = 0.003f;
constexpr float kMostWays = 8.0f;

// What a way that goes on stands for, at the most: highlights seen over it are as wide as that.
// Were it all of what is reflected there, they would be too wide to send on all of their light.
constexpr float kWidest = 0.1f;

// Steps of the solution end where it changes by less than this share of itself, or after so many.
constexpr double kDone = 1e-4;
constexpr int kMostSteps = 500;

// Different random numbers of one hit; ScatteredOnce takes those before.
enum Use : uint32_t { kLobe = 3, kDiffuse, kWhich };

uint32_t seedOf(const Hit& hit) { return hashOfPoint(hit.triangle, hit.u, hit.v); }

// Of ways that go on, along lobes and by the cosine.
struct Chances {
    SpreadPlaces lobe, diffuse;

    explicit Chances(uint32_t seed) : lobe(seed, kLobe), diffuse(seed, kDiffuse) {}
};

float waysOf(float solid_angle) { return std::clamp(solid_angle / kAngleOfWay, 1.0f, kMostWays); }

// Ways that go on, together.
struct Ways {
    std::vector<size_t> of;  // ray
    std::vector<vec3> weights;
    std::vector<vec3> origins, directions;
    std::vector<float> solid_angles;

    Rays rays(size_t first, size_t count, bool without_caustics) const {
        return Rays{.directions = directions,
                    .solid_angles = solid_angles,
                    .origins = origins,
                    .without_caustics = without_caustics}
            .part(first, count);
    }
    void add(size_t ray, const vec3& weight, const vec3& origin, const vec3& direction,
             float solid_angle) {
        of.push_back(ray);
        weights.push_back(weight);
        origins.push_back(origin);
        directions.push_back(direction);
        solid_angles.push_back(solid_angle);
    }
};

}  // namespace

// What a ray meets, and what scatters light there.
struct ScatteredAgain::Point {
    struct Glossy {
        SurfacePoint p;
        Scatterer surface;
        vec3 specular_albedo;
    };
    const Hit& hit;
    vec3 wo;
    std::optional<Glossy> glossy;  // none: Lambertian

    Point(const Scene& scene, const Hit& hit_, const vec3& wo_) : hit(hit_), wo(wo_) {
        if (isLambertian(scene.materials[scene.materials_of[hit.triangle]])) {
            return;
        }
        const SurfacePoint p = surfacePoint(scene, hit.triangle, hit.u, hit.v, wo, hit.distance);
        const MaterialParams material = materialAt(scene, p.triangle, p.barycentric);
        const Scatterer surface = scattererAt(scene, p, material);
        const Brdf& brdf = surface.brdf;
        glossy = {p, surface,
                  specularAlbedo(glm::dot(surface.n, wo), material.roughness, brdf.f0, brdf.f90)};
    }
    // Of a Lambertian surface, at barycentric coordinates uv of its triangle.
    vec3 albedoAt(const Scene& scene, const vec2& uv) const {
        return materialAt(scene, hit.triangle, vec3(1.0f - uv.x - uv.y, uv)).base_color;
    }
    vec3 albedo(const Scene& scene) const {
        return glossy ? glossy->surface.brdf.diffuse : albedoAt(scene, vec2(hit.u, hit.v));
    }
    ElementSite site(const Scene& scene) const {
        return elementSiteAt(scene, hit, vec2(hit.u, hit.v), wo);
    }

    // Goes on along the lobe, by chance, in so many ways on average where it reflects all light.
    void followLobe(const Scene& scene, size_t ray, const vec3& weight, float most,
                    SpreadPlaces& places, Ways& ways) const {
        const Brdf& brdf = glossy->surface.brdf;
        const float wanted =
            most * std::min(kOftener * luminance(weight * glossy->specular_albedo), 1.0f);
        const mat3 frame = tangentFrame(glossy->surface.n);
        vec3 u = places.next();
        const auto count = static_cast<int>(wanted + u.z);
        for (int k = 0; k < count; ++k) {
            u = k > 0 ? places.next() : u;
            const auto along =
                sampleLobe(glm::transpose(frame) * wo, brdf.alpha, brdf.f0, brdf.f90, vec2(u));
            const vec3 direction = along ? glm::normalize(frame * along->wi) : vec3(0.0f);
            if (glm::dot(direction, glossy->p.n_g) > 0.0f) {
                ways.add(ray, weight * along->weight / wanted, glossy->p.eye(scene), direction,
                         std::min(1.0f / along->density, kWidest));
            }
        }
    }
    // And by the cosine.
    void followDiffuse(const Scene& scene, size_t ray, const vec3& weight, const vec3& u,
                       Ways& ways) const {
        const vec3 reflected = weight * albedo(scene);
        const float chance = std::min(kOftener * luminance(reflected), 1.0f);
        if (u.z >= chance) {
            return;
        }
        const ElementSite from = site(scene);
        const vec3 direction = glm::normalize(tangentFrame(from.normal) * cosineDirection(vec2(u)));
        if (glm::dot(direction, from.side.n_g) > 0.0f) {
            ways.add(ray, reflected / chance, from.side.start(), direction, kWidest);
        }
    }
};

// The elements that say what is kept at a point, and by which weights. They add up to one, and some
// may be negative: they are those of a plane fitted to the values around. Where elements lie on one
// side, as along a wall, their mean would be the light of a place farther off.
struct ScatteredAgain::Neighbours {
    static constexpr size_t kMost = 64;
    size_t count = 0;
    std::array<uint32_t, kMost> elements;
    std::array<float, kMost> weights;
};

// The irradiance of an element: of the light that its rays see at once, and sums of weights times
// irradiances of others.
struct ScatteredAgain::Equation {
    struct Term {
        uint32_t element;
        int followed;
        vec3 weight;
    };
    std::vector<vec3> light;  // [rays followed]
    std::vector<Term> terms;
};

ScatteredAgain::ScatteredAgain(const ScatteredOnce& once, Elements elements,
                               const std::vector<Bounds>& near, int bounces)
    : OutgoingLight(once.tracer()),
      once_(once),
      bounces_(bounces),
      elements_(std::move(elements)),
      cells_(once.tracer(), near) {
    std::vector<Equation> equations(elements_.size());
    parallelFor(static_cast<int>(equations.size()), [&](int i) {
        const auto k = static_cast<size_t>(i);
        equations[k] = equationOf(k);
    });
    solve(equations);
}

int ScatteredAgain::mostFollowed() const { return std::min(kMostFollowed, bounces_ - 1); }

// Where a ray meets a surface the first of the elements around is asked, and by how much another
// one's light differs: that one by chance, each as often as it counts, since there are many rays.
// What arrives of light that is the same everywhere has no noise, which all bounces would add up.
ScatteredAgain::Equation ScatteredAgain::equationOf(size_t element) const {
    constexpr float kEach = kPi / (kRows * kColumns);
    const ElementSite& site = elements_.site(element);
    const Looks looks(site, kRows, kColumns, static_cast<uint32_t>(element));
    const Rays rays{.origin = site.side.start(),
                    .directions = looks.directions,
                    .solid_angles = looks.solid_angles};
    Equation result{.light = std::vector<vec3>(static_cast<size_t>(mostFollowed()) + 1),
                    .terms = {}};
    static_assert(kRows * kColumns <= static_cast<int>(kTogether));
    const size_t count = looks.directions.size();
    Hit hits[kTogether];
    vec3 light[kTogether];
    tracer().meet(rays, hits);
    once_.radiance(rays, {hits, count}, light);
    const auto add = [&](size_t, int followed, const vec3& radiance) {
        vec3& sum = result.light[static_cast<size_t>(followed)];
        sum += finite(radiance) ? kEach * radiance : vec3(0.0f);
    };
    for (size_t i = 0; i < count; ++i) {
        // The sky's light, as that of lamps, is added where rays meet surfaces.
        if (hits[i].found()) {
            add(i, 0, light[i]);
        }
    }
    const auto ask = [&](size_t, int followed, const Point& q, const vec3& weight,
                         const vec3& lobe) {
        const ElementSite at = q.site(scene());
        const Neighbours near = neighbours(at.side.position, at.normal);
        if (near.count == 0) {
            return false;
        }
        float sum = 0.0f;
        for (size_t k = 0; k < near.count; ++k) {
            sum += std::abs(near.weights[k]);
        }
        float u = sum * randomPlace(seedOf(q.hit), kWhich).x;
        size_t other = 0;
        while (other + 1 < near.count && u >= std::abs(near.weights[other])) {
            u -= std::abs(near.weights[other++]);
        }
        const vec3 each = kEach / kPi * weight * (q.albedo(scene()) + lobe);
        const float share = other > 0 ? std::copysign(sum, near.weights[other]) : 0.0f;
        result.terms.push_back(
            {.element = near.elements[0], .followed = followed, .weight = (1.0f - share) * each});
        if (other > 0) {
            result.terms.push_back(
                {.element = near.elements[other], .followed = followed, .weight = share * each});
        }
        return true;
    };
    // Of so many elements each ray's lobe is followed once.
    const Rays once{.origin = rays.origin, .directions = rays.directions};
    follow(once, {hits, count}, add, ask);
    result.terms.shrink_to_fit();
    return result;
}

// Step k finds the irradiance of light that is scattered k times at the most from that of light
// scattered less often, until all bounces asked for are there or nothing changes any more.
void ScatteredAgain::solve(std::span<const Equation> equations) {
    const auto ways = static_cast<size_t>(mostFollowed()) + 1;
    kept_.assign(ways, std::vector<vec3>(equations.size(), vec3(0.0f)));
    double before = std::numeric_limits<double>::infinity();
    for (int k = 1; k < bounces_ && k <= kMostSteps; ++k) {
        std::vector<vec3> next(equations.size());
        parallelFor(
            static_cast<int>(equations.size()),
            [&](int i) {
                const Equation& equation = equations[static_cast<size_t>(i)];
                vec3 sum(0.0f);
                for (size_t f = 0; f < ways && f < static_cast<size_t>(k); ++f) {
                    sum += equation.light[f];
                }
                for (const Equation::Term& term : equation.terms) {
                    sum += term.weight * kept_[static_cast<size_t>(term.followed)][term.element];
                }
                next[static_cast<size_t>(i)] = glm::max(sum, vec3(0.0f));
            },
            64);
        double change = 0.0, worst = 0.0;
        for (size_t i = 0; i < next.size(); ++i) {
            const double changed = luminance(glm::abs(next[i] - kept_[0][i]));
            const double all = luminance(next[i]);
            change += changed;
            worst = all > 0.0 ? std::max(worst, changed / all) : worst;
        }
        // Once all light is in, each bounce brings less than the one before.
        const bool settled = k > static_cast<int>(ways);
        if (settled && change > before) {
            break;
        }
        before = change;
        std::rotate(kept_.begin(), kept_.end() - 1, kept_.end());
        kept_.front() = std::move(next);
        if (settled && worst <= kDone) {
            break;
        }
    }
    if (bounces_ > kMostFollowed + 1) {  // more steps would change nothing
        std::fill(kept_.begin() + 1, kept_.end(), kept_.front());
    }
}

// Goes on from what rays meet. Calls ask(ray, rays followed, point, weight, lobe) for each surface,
// the first ones among them: by that weight arrives what it reflects diffusely of the irradiance
// that is kept there, and what it would by `lobe`, an albedo that is to count as if diffuse; where
// it returns false, nothing is kept. And light(ray, rays followed, radiance) for what lights do to
// the surfaces after the first ones.
template <class Light, class Ask>
void ScatteredAgain::follow(const Rays& rays, std::span<const Hit> hits, const Light& light,
                            const Ask& ask) const {
    const int most = mostFollowed();
    // Ways by specular lobes alone, of rays that ask for no caustics, are the second.
    std::array<Ways, 2> next;
    // What rays from one point meet goes on in strata, set by set, the rest by chance of its own:
    // what led there is strata already.
    const auto found =
        std::find_if(hits.begin(), hits.end(), [](const Hit& h) { return h.found(); });
    if (found == hits.end()) {
        return;
    }
    std::vector<Chances> sets;
    for (uint32_t k = 0; k < (rays.sets.empty() ? 1 : Rays::kSets); ++k) {
        sets.emplace_back(pcgHash(k + seedOf(*found)));
    }
    const auto goOn = [&](const Hit& hit, const vec3& wo, size_t ray, int followed,
                          const vec3& weight, bool without_caustics, Chances& chances) {
        if (followed == bounces_ - 1) {
            return;  // scattered often enough
        }
        const Point q(scene(), hit, wo);
        const bool last = followed == most;
        const bool known = ask(ray, followed, q, weight,
                               last && q.glossy ? q.glossy->specular_albedo : vec3(0.0f));
        if (!last && !known) {
            q.followDiffuse(scene(), ray, weight, chances.diffuse.next(), next[0]);
        }
        if (!last && q.glossy) {
            const bool specular = without_caustics && isSpecular(q.glossy->surface.brdf);
            const float ways = followed == 0 ? waysOf(rays.solidAngle(ray)) : 1.0f;
            q.followLobe(scene(), ray, weight, ways, chances.lobe, next[specular ? 1 : 0]);
        }
    };
    for (size_t i = 0; i < hits.size(); ++i) {
        if (hits[i].found()) {
            goOn(hits[i], -rays.directions[i], i, 0, vec3(1.0f), rays.without_caustics,
                 sets[rays.setOf(i)]);
        }
    }
    const auto pursue = [&](const Ways& ways, int followed, bool without_caustics) {
        for (size_t first = 0; first < ways.of.size(); first += kTogether) {
            const size_t count = std::min(kTogether, ways.of.size() - first);
            const Rays cast = ways.rays(first, count, without_caustics);
            Hit met[kTogether];
            vec3 seen[kTogether];
            tracer().meet(cast, met);
            once_.radiance(cast, {met, count}, seen);
            for (size_t i = 0; i < count; ++i) {
                // Lamps and the sky have already lit the surface that the way comes from.
                if (met[i].found()) {
                    const vec3& weight = ways.weights[first + i];
                    light(ways.of[first + i], followed, weight * seen[i]);
                    Chances chances(seedOf(met[i]));
                    goOn(met[i], -cast.directions[i], ways.of[first + i], followed, weight,
                         without_caustics, chances);
                }
            }
        }
    };
    for (int followed = 1; !next[0].of.empty() || !next[1].of.empty(); ++followed) {
        const std::array<Ways, 2> ways = std::exchange(next, {});
        pursue(ways[0], followed, false);
        pursue(ways[1], followed, true);
    }
}

ScatteredAgain::Neighbours ScatteredAgain::neighbours(const vec3& p, const vec3& n) const {
    // Of the fit: keeps it from following chance where elements are few, or lie on a line.
    constexpr float kStiffness = 0.02f;
    const mat3 frame = tangentFrame(n);
    Neighbours near;
    std::array<vec2, Neighbours::kMost> places;  // in the plane
    float sum = 0.0f, spread = 0.0f;
    elements_.around(p, n, [&](size_t i, float weight) {
        size_t k = near.count;
        if (k == Neighbours::kMost) {  // for the one that counts least
            k = static_cast<size_t>(std::min_element(near.weights.begin(), near.weights.end()) -
                                    near.weights.begin());
            if (near.weights[k] >= weight) {
                return;
            }
        } else {
            ++near.count;
        }
        near.elements[k] = static_cast<uint32_t>(i);
        near.weights[k] = weight;
    });
    for (size_t k = 0; k < near.count; ++k) {
        places[k] = vec2((elements_.site(near.elements[k]).side.position - p) * frame);
        sum += near.weights[k];
        spread += near.weights[k] * glm::dot(places[k], places[k]);
    }
    if (near.count == 0) {
        return near;
    }
    const float unit = spread > 0.0f ? std::sqrt(sum / spread) : 1.0f;
    mat3 normal(0.0f);
    for (size_t k = 0; k < near.count; ++k) {
        const vec3 one(1.0f, unit * places[k]);
        normal += glm::outerProduct(one, one) * (near.weights[k] / sum);
    }
    normal[1][1] += kStiffness;
    normal[2][2] += kStiffness;
    const vec3 plane = glm::inverse(normal)[0];
    float magnitude = 0.0f;
    std::array<float, Neighbours::kMost> fit;
    for (size_t k = 0; k < near.count; ++k) {
        near.weights[k] /= sum;
        fit[k] = near.weights[k] * glm::dot(plane, vec3(1.0f, unit * places[k]));
        magnitude += std::abs(fit[k]);
    }
    // Far from all of them a plane would make much of their differences.
    const float share = std::min(1.0f / std::max(magnitude - 1.0f, 1e-6f), 1.0f);
    for (size_t k = 0; k < near.count; ++k) {
        near.weights[k] = glm::mix(near.weights[k], fit[k], share);
    }
    return near;
}

std::optional<vec3> ScatteredAgain::irradiance(const ElementSite& at, int followed) const {
    const std::vector<vec3>& kept = kept_[static_cast<size_t>(followed)];
    const Neighbours near = neighbours(at.side.position, at.normal);
    vec3 sum(0.0f);
    for (size_t k = 0; k < near.count; ++k) {
        sum += near.weights[k] * kept[near.elements[k]];
    }
    return near.count > 0 ? std::optional(glm::max(sum, vec3(0.0f))) : std::nullopt;
}

void ScatteredAgain::radiance(const Rays& rays, std::span<const Hit> hits, vec3* radiance) const {
    for (const Hit& hit : hits) {
        if (hit.found()) {
            cells_.prefetch(hit);
        }
    }
    once_.radiance(rays, hits, radiance);
    int64_t asked = 0, missed = 0;
    follow(
        rays, hits, [&](size_t ray, int, const vec3& light) { radiance[ray] += light; },
        [&](size_t ray, int followed, const Point& q, const vec3& weight, const vec3& lobe) {
            // Of a Lambertian surface what is reflected is kept, textures included; by the side of
            // the triangle alone, not by where it is seen from.
            const vec3 n_g = geometricNormal(scene(), static_cast<int>(q.hit.triangle));
            const vec3 side = q.hit.back ? -n_g : n_g;
            const auto find = [&](const vec2& uv) {
                const auto kept = irradiance(elementSiteAt(scene(), q.hit, uv, side), followed);
                return kept && !q.glossy ? std::optional(*kept * q.albedoAt(scene(), uv)) : kept;
            };
            // Cells keep what is asked for where rays meet a surface first.
            const float area = rays.solidAngle(ray) * q.hit.distance * q.hit.distance;
            const auto cell = followed == 0 || bounces_ == kAllBounces ? cells_.cellOf(q.hit, area)
                                                                       : std::nullopt;
            const std::optional<vec3> kept =
                cell ? cells_.at(*cell, [&] { return find(cell->middle); })
                     : find(vec2(q.hit.u, q.hit.v));
            ++asked;
            if (!kept) {
                ++missed;
                return false;
            }
            radiance[ray] +=
                weight / kPi * *kept * (q.glossy ? q.albedo(scene()) + lobe : vec3(1.0f));
            return true;
        });
    asked_.fetch_add(asked, std::memory_order_relaxed);
    missed_.fetch_add(missed, std::memory_order_relaxed);
}

double ScatteredAgain::lackingShare(std::span<const ElementSite> sites) const {
    const auto lacks = [this](const ElementSite& at) {
        return neighbours(at.side.position, at.normal).count == 0;
    };
    return static_cast<double>(std::count_if(sites.begin(), sites.end(), lacks)) /
           static_cast<double>(std::max<size_t>(sites.size(), 1));
}

double ScatteredAgain::missedShare() const {
    return static_cast<double>(missed_) / static_cast<double>(std::max<int64_t>(asked_, 1));
}

}  // namespace sheen
