#include "light/element_light.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/directions.h"
#include "core/parallel.h"
#include "light/place_elements.h"
#include "rays/jitter.h"

namespace sheen {
namespace {

// Rays of an element.
constexpr int kRows = 16, kColumns = 16;

// Steps of the solution end where it changes by less than this share of itself, or after so many.
constexpr double kDone = 1e-4;
constexpr int kMostSteps = 500;

// The random number of a hit by which an element is chosen; those before are others' (WaysOn).
constexpr uint32_t kWhich = 5;

}  // namespace

// The elements that say what is kept at a point, and by which weights. They add up to one, and some
// may be negative: they are those of a plane fitted to the values around. Where elements lie on one
// side, as along a wall, their mean would be the light of a place farther off.
struct ElementLight::Neighbours {
    static constexpr size_t kMost = 64;
    size_t count = 0;
    std::array<uint32_t, kMost> elements;
    std::array<float, kMost> weights;
};

// The irradiance of an element: of the light that its rays see at once, and sums of weights times
// irradiances of others.
struct ElementLight::Equation {
    struct Term {
        uint32_t element;
        int followed;
        vec3 weight;
    };
    std::vector<vec3> light;  // [rays followed]
    std::vector<Term> terms;
};

ElementLight::ElementLight(const ScatteredOnce& once, Elements elements, int bounces)
    : elements_(std::move(elements)) {
    const WaysOn ways(once, bounces);
    std::vector<Equation> equations(elements_.size());
    parallelFor(static_cast<int>(equations.size()), [&](int i) {
        const auto k = static_cast<size_t>(i);
        equations[k] = equationOf(ways, k);
    });
    solve(equations, bounces, ways.most());
}

ElementLight::ElementLight(ByteReader& in) : elements_(in) {
    kept_.resize(in.get<uint64_t>());
    for (std::vector<vec3>& irradiances : kept_) {
        irradiances = in.get<std::vector<vec3>>();
    }
}

void ElementLight::write(ByteWriter& out) const {
    elements_.write(out);
    out.put(uint64_t{kept_.size()});
    for (const std::vector<vec3>& irradiances : kept_) {
        out.put(irradiances);
    }
}

// Where a ray meets a surface the first of the elements around is asked, and by how much another
// one's light differs: that one by chance, each as often as it counts, since there are many rays.
// What arrives of light that is the same everywhere has no noise, which all bounces would add up.
ElementLight::Equation ElementLight::equationOf(const WaysOn& ways, size_t element) const {
    constexpr float kEach = kPi / (kRows * kColumns);
    const ElementSite& site = elements_.site(element);
    const Looks looks(site, kRows, kColumns, static_cast<uint32_t>(element));
    const Rays rays{.origin = site.side.start(),
                    .directions = looks.directions,
                    .solid_angles = looks.solid_angles};
    Equation result{.light = std::vector<vec3>(static_cast<size_t>(ways.most()) + 1), .terms = {}};
    static_assert(kRows * kColumns <= static_cast<int>(OutgoingLight::kTogether));
    const size_t count = looks.directions.size();
    Hit hits[OutgoingLight::kTogether];
    vec3 light[OutgoingLight::kTogether];
    ways.tracer().meet(rays, hits);
    ways.once().radiance(rays, {hits, count}, light);
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
    const auto ask = [&](size_t, int followed, const WaysOn::Point& q, const vec3& weight,
                         const vec3& lobe) {
        const ElementSite at = q.site(ways.scene());
        const Neighbours near = neighbours(at.side.position, at.normal);
        if (near.count == 0) {
            return false;
        }
        float sum = 0.0f;
        for (size_t k = 0; k < near.count; ++k) {
            sum += std::abs(near.weights[k]);
        }
        float u = sum * randomPlace(hashOfPoint(q.hit.triangle, q.hit.u, q.hit.v), kWhich).x;
        size_t other = 0;
        while (other + 1 < near.count && u >= std::abs(near.weights[other])) {
            u -= std::abs(near.weights[other++]);
        }
        const vec3 each = kEach / kPi * weight * (q.albedo(ways.scene()) + lobe);
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
    ways.follow(once, {hits, count}, add, ask);
    result.terms.shrink_to_fit();
    return result;
}

// Step k finds the irradiance of light that is scattered k times at the most from that of light
// scattered less often, until all bounces asked for are there or nothing changes any more.
void ElementLight::solve(std::span<const Equation> equations, int bounces, int most) {
    const auto ways = static_cast<size_t>(most) + 1;
    kept_.assign(ways, std::vector<vec3>(equations.size(), vec3(0.0f)));
    double before = std::numeric_limits<double>::infinity();
    for (int k = 1; k < bounces && k <= kMostSteps; ++k) {
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
    if (bounces > most + 1) {  // more steps would change nothing
        std::fill(kept_.begin() + 1, kept_.end(), kept_.front());
    }
}

ElementLight::Neighbours ElementLight::neighbours(const vec3& p, const vec3& n) const {
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
        const vec2 place = unit * places[k];
        const float weight = near.weights[k] / sum;
        normal[0] += vec3(1.0f, place) * weight;
        normal[1][1] += place.x * place.x * weight;
        normal[1][2] += place.x * place.y * weight;
        normal[2][2] += place.y * place.y * weight;
    }
    normal[1][0] = normal[0][1];
    normal[2][0] = normal[0][2];
    normal[2][1] = normal[1][2];
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

std::optional<vec3> ElementLight::irradiance(const ElementSite& at, int followed) const {
    const std::vector<vec3>& kept = kept_[static_cast<size_t>(followed)];
    const Neighbours near = neighbours(at.side.position, at.normal);
    vec3 sum(0.0f);
    for (size_t k = 0; k < near.count; ++k) {
        sum += near.weights[k] * kept[near.elements[k]];
    }
    return near.count > 0 ? std::optional(glm::max(sum, vec3(0.0f))) : std::nullopt;
}

}  // namespace sheen
