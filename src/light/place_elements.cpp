#include "light/place_elements.h"

#include <algorithm>
#include <cmath>

#include "core/directions.h"
#include "core/parallel.h"
#include "rays/jitter.h"

namespace sheen {
namespace {

// Of rays: from the points that light is looked for from, and from each element.
constexpr int kLookRows = 4, kLookColumns = 8;
constexpr int kElementRows = 6, kElementColumns = 16;

constexpr size_t kMostElements = 4000;
constexpr size_t kMostRounds = 5;
// Where there would be more at first, they lie so much farther apart.
constexpr float kFarther = 1.2f;

// Elements lie as far apart as this share of the way that they are seen over; those that only other
// elements see, twice as far: they count for less.
constexpr float kOfWay = 0.4f;
constexpr float kOfFurtherWay = 2.0f * kOfWay;
// And no farther than this share of the harmonic mean distance of what they see: light that comes
// from nearby varies. [WRC88]
constexpr float kOfMean = 0.3f;
// Ways shorter than this share of the usual one count as long as that, and the mean makes them lie
// no closer than a quarter of what follows: in a corner there is no heap of elements.
constexpr float kShortWay = 0.25f;
constexpr float kLeastOfShort = 0.25f * kOfWay;

float medianOf(std::vector<float> values) {
    if (values.empty()) {
        return 0.0f;
    }
    const auto middle = values.begin() + static_cast<ptrdiff_t>(values.size() / 2);
    std::nth_element(values.begin(), middle, values.end());
    return *middle;
}

// What surfaces a site sees; for their spacing the way to them.
std::vector<ElementSite> look(const Tracer& tracer, const ElementSite& from, const Looks& looks) {
    std::vector<Hit> hits(looks.directions.size());
    tracer.meet({.origin = from.side.start(), .directions = looks.directions}, hits.data());
    std::vector<ElementSite> sites;
    for (size_t i = 0; i < hits.size(); ++i) {
        if (hits[i].found()) {
            sites.push_back(elementSiteAt(tracer.scene(), hits[i], vec2(hits[i].u, hits[i].v),
                                          -looks.directions[i]));
            sites.back().spacing = hits[i].distance;
        }
    }
    return sites;
}

// From each of several sites, in order.
std::vector<ElementSite> lookFromAll(const Tracer& tracer, std::span<const ElementSite> from) {
    std::vector<std::vector<ElementSite>> looked(from.size());
    parallelFor(static_cast<int>(from.size()), [&](int i) {
        const auto k = static_cast<size_t>(i);
        const auto seed = static_cast<uint32_t>(i);
        looked[k] = look(tracer, from[k], Looks(from[k], kLookRows, kLookColumns, seed));
    });
    std::vector<ElementSite> all;
    for (const std::vector<ElementSite>& sites : looked) {
        all.insert(all.end(), sites.begin(), sites.end());
    }
    return all;
}

void addLacking(std::span<const ElementSite> wanted, Elements& elements) {
    for (const ElementSite& site : wanted) {
        if (elements.size() < kMostElements && elements.lacks(site)) {
            elements.add(site);
        }
    }
}

// Elements on what is looked at first: where they are wanted close to each other before elsewhere,
// since those that lie farther apart would do there too.
Elements placeFirst(std::vector<ElementSite>& wanted) {
    std::stable_sort(wanted.begin(), wanted.end(), [](const ElementSite& a, const ElementSite& b) {
        return a.spacing < b.spacing;
    });
    while (true) {
        Elements elements;
        addLacking(wanted, elements);
        if (elements.size() < kMostElements / 2) {
            return elements;
        }
        for (ElementSite& site : wanted) {
            site.spacing *= kFarther;
        }
    }
}

// Along a surface of unit normal n, as far as to where the plane through the end of `along`, with
// its unit normal, stands on the surface nearest to the way's start; as far as to that end where
// the plane hardly stands up.
float wayToPlane(const vec3& along, const vec3& plane, const vec3& n) {
    constexpr float kStanding = 0.3f;
    const vec3 across = plane - glm::dot(plane, n) * n;
    const float length = glm::length(across);
    return length < kStanding ? glm::length(along) : std::abs(glm::dot(along, across)) / length;
}

// What an element's rays tell of its surroundings.
struct Surroundings {
    Elements::Ways ways;
    float mean = 0;  // harmonic, distance
    std::vector<ElementSite> seen;
};

Surroundings surroundingsOf(const Tracer& tracer, const Elements& elements, size_t i) {
    const ElementSite& site = elements.site(i);
    const Looks looks(site, kElementRows, kElementColumns, ~static_cast<uint32_t>(i));
    Surroundings result{.ways = {}, .seen = look(tracer, site, looks)};
    result.ways.fill(kInfinity);
    float nearness = 0.0f;
    for (const ElementSite& met : result.seen) {
        nearness += 1.0f / met.spacing;
        const vec3 way = met.side.position - site.side.position;
        const float height = glm::dot(way, site.normal);
        const vec3 along = way - height * site.normal;
        if (height * height < glm::dot(along, along)) {
            float& free = result.ways[static_cast<size_t>(elements.sector(i, way))];
            free = std::min(free, wayToPlane(along, met.side.n_g, site.normal));
        }
    }
    result.mean = static_cast<float>(looks.directions.size()) / nearness;
    return result;
}

}  // namespace

Looks::Looks(const ElementSite& site, int rows, int columns, uint32_t seed) {
    const mat3 frame = tangentFrame(site.normal);
    const auto count = static_cast<float>(rows * columns);
    const uint32_t mixed = pcgHash(seed);
    for (int k = 0; k < rows * columns; ++k) {
        const vec2 place = randomPlace(mixed, static_cast<uint32_t>(k));
        const vec3 local =
            cosineDirection((vec2(k / columns, k % columns) + place) / vec2(rows, columns));
        const vec3 direction = glm::normalize(frame * local);
        if (glm::dot(direction, site.side.n_g) > 0.0f) {
            directions.push_back(direction);
            solid_angles.push_back(std::min(kPi / (count * std::max(local.z, 1e-3f)), kPi));
        }
    }
}

ElementSite elementSiteAt(const Scene& scene, const Hit& hit, const vec2& uv, const vec3& wo) {
    const SurfacePoint p = surfacePoint(scene, hit.triangle, uv.x, uv.y, wo, hit.distance);
    return {.side = {.position = p.position,
                     .n_g = p.n_g,
                     .toward_viewer = wo,
                     .offset = surfaceOffset(scene, p.triangle, p.position, p.n_g, p.distance)},
            .normal = normalsAt(scene, p.triangle, p.barycentric, p.n_g, p.n_g).smooth};
}

Elements placeElements(const Tracer& tracer, std::span<const ElementSite> from) {
    std::vector<ElementSite> wanted = lookFromAll(tracer, from);
    std::vector<float> ways;
    for (const ElementSite& site : wanted) {
        ways.push_back(site.spacing);
    }
    const float short_way = kShortWay * medianOf(std::move(ways));
    for (ElementSite& site : wanted) {
        site.spacing = kOfWay * std::max(site.spacing, short_way);
    }
    Elements elements = placeFirst(wanted);
    for (size_t known = 0, round = 1; known < elements.size(); ++round) {
        std::vector<Surroundings> found(elements.size() - known);
        parallelFor(static_cast<int>(found.size()), [&](int i) {
            const auto k = static_cast<size_t>(i);
            found[k] = surroundingsOf(tracer, elements, known + k);
        });
        for (size_t k = 0; k < found.size(); ++k) {
            elements.know(known + k, found[k].ways,
                          std::max(kOfMean * found[k].mean, kLeastOfShort * short_way));
            for (ElementSite& site : found[k].seen) {
                site.spacing = kOfFurtherWay * std::max(site.spacing, short_way);
                wanted.push_back(site);
            }
        }
        known = elements.size();
        elements.reindex();
        if (round < kMostRounds) {
            addLacking(wanted, elements);
        }
    }
    return elements;
}

}  // namespace sheen
