#include "hints/hint_grid.h"

#include <algorithm>
#include <cmath>

#include "core/directions.h"
#include "core/parallel.h"
#include "hints/even_directions.h"
#include "rays/jitter.h"
#include "rays/surface_point.h"

namespace sheen {
namespace {

// Hints beside a wall lie half a cell before it; by this share of a cell all are moved, so that
// none lies in a surface that halves the box.
constexpr float kShift = 0.01f;

// From the middle of a box of these half sides along a unit direction to its border.
float toBorder(const vec3& half, const vec3& d) {
    const vec3 times = half / glm::max(glm::abs(d), vec3(1e-6f));
    return glm::min(times.x, glm::min(times.y, times.z));
}

HintLook lookAt(const Scene& scene, const Hit& hit, const vec3& direction) {
    const SurfacePoint p =
        surfacePoint(scene, hit.triangle, hit.u, hit.v, -direction, hit.distance);
    const MaterialParams material = materialAt(scene, p.triangle, p.barycentric);
    const Scatterer surface = scattererAt(scene, p, material);
    const float NoV = std::max(glm::dot(surface.n, p.wo), 0.0f);
    return {.position = p.eye(scene),
            .n_g = p.n_g,
            .albedo = hit.weight *
                      (surface.brdf.diffuse +
                       specularAlbedo(NoV, material.roughness, surface.brdf.f0, surface.brdf.f90))};
}

// What counts as a flat box's thickness.
float thinnestOf(const Bounds& box) {
    constexpr float kThinnest = 1.0f / 16.0f;  // of the longest side
    const vec3 size = box.upper - box.lower;
    return kThinnest * glm::max(size.x, glm::max(size.y, size.z));
}

}  // namespace

HintLattice latticeOf(const Bounds& box, int hints) {
    const vec3 sides = glm::max(box.upper - box.lower, vec3(thinnestOf(box)));
    const double volume = double{sides.x} * double{sides.y} * double{sides.z};
    const auto step = static_cast<float>(std::cbrt(volume / hints));
    HintLattice lattice;
    lattice.counts = glm::max(ivec3(glm::round(sides / step)), ivec3(1));
    lattice.cell = sides / vec3(lattice.counts);
    lattice.origin = box.center() - 0.5f * sides + kShift * lattice.cell;
    return lattice;
}

HintLattice latticeWithin(const HintLattice& whole, const Bounds& box, int hints) {
    constexpr int kFinest = 12;  // halvings
    constexpr int kStep = 4;     // the box begins and ends at multiples of so many cells
    HintLattice lattice = whole;
    const vec3 size = glm::max(box.upper - box.lower, vec3(thinnestOf(box))) / whole.cell;
    double cells = std::max(double{size.x} * double{size.y} * double{size.z}, 1e-9);
    for (int k = 0; k < kFinest && 4.0 * cells < hints; ++k) {
        lattice.cell *= 0.5f;
        cells *= 8.0;
    }
    const vec3 lower = (box.lower - lattice.origin) / (lattice.cell * float{kStep});
    const vec3 upper = (box.upper - lattice.origin) / (lattice.cell * float{kStep});
    lattice.first = ivec3(glm::floor(lower)) * kStep;
    lattice.counts = ivec3(glm::ceil(upper)) * kStep - lattice.first;
    return lattice;
}

const std::vector<vec3>& HintGrid::directions() {
    static const std::vector<vec3> kDirections = evenDirections(kLooks);
    return kDirections;
}

HintGrid::HintGrid(const Tracer& tracer, const HintLattice& lattice)
    : tracer_(tracer),
      lattice_(lattice),
      points_(static_cast<size_t>(lattice.count()) * kLooks),
      looks_(points_.size()),
      links_(static_cast<size_t>(lattice.count()), 0) {
    parallelFor(
        lattice_.count(), [this](int hint) { look(hint); }, kHintGrain);
    parallelFor(
        lattice_.count(), [this](int hint) { link(hint); }, kHintGrain);
}

uint32_t HintGrid::seedOf(int hint) const {
    const ivec3 place = lattice_.first + lattice_.at(hint);
    return pcgHash(
        static_cast<uint32_t>(place.x) +
        pcgHash(static_cast<uint32_t>(place.y) + pcgHash(static_cast<uint32_t>(place.z))));
}

mat3 HintGrid::rotationOf(int hint) const {
    constexpr uint32_t kTurn = kLooks;  // random numbers beyond those of looks
    const uint32_t seed = seedOf(hint);
    const vec2 u = randomPlace(seed, kTurn);
    const float turn = 2.0f * kPi * randomPlace(seed, kTurn + 1).x;
    const float z = 1.0f - 2.0f * u.x;
    const float r = std::sqrt(std::max(1.0f - z * z, 0.0f));
    const mat3 frame =
        tangentFrame(vec3(r * std::cos(2.0f * kPi * u.y), r * std::sin(2.0f * kPi * u.y), z));
    const float c = std::cos(turn), s = std::sin(turn);
    return {c * frame[0] + s * frame[1], c * frame[1] - s * frame[0], frame[2]};
}

// What lies around a hint. A point of its cell is along each ray, before what this meets.
void HintGrid::look(int hint) {
    constexpr float kBefore = 0.9f;
    const ivec3 at = lattice_.at(hint);
    const vec3 middle = lattice_.middle(at);
    const mat3 rotation = rotationOf(hint);
    std::array<vec3, kLooks> d;
    std::transform(directions().begin(), directions().end(), d.begin(),
                   [&](const vec3& direction) { return rotation * direction; });
    std::array<Hit, kLooks> hits;
    tracer_.meet({.origin = middle, .directions = d}, hits.data());
    const uint32_t seed = seedOf(hint);
    for (size_t k = 0; k < d.size(); ++k) {
        const size_t i = static_cast<size_t>(hint) * kLooks + k;
        const float u = randomPlace(seed, static_cast<uint32_t>(k)).x;
        const float wanted = std::cbrt(u) * toBorder(0.5f * lattice_.cell, d[k]);
        points_[i] = middle + d[k] * std::min(wanted, kBefore * hits[k].distance);
        if (hits[k].found()) {
            looks_[i] = lookAt(tracer_.scene(), hits[k], d[k]);
        } else {
            looks_[i] = {.position = middle, .n_g = vec3(0.0f)};
        }
    }
}

// Which hints of those around it a hint sees. Both ends ask, from their own side: rays of one pair
// meet the same.
void HintGrid::link(int hint) {
    const ivec3 at = lattice_.at(hint);
    const vec3 middle = lattice_.middle(at);
    std::array<Way, Tracer::kPacket> ways;
    std::array<uint32_t, Tracer::kPacket> bits{};
    size_t count = 0;
    uint32_t& links = links_[static_cast<size_t>(hint)];
    const auto ask = [&] {
        const Tracer::Shares shares = tracer_.passing({ways.data(), count});
        for (size_t k = 0; k < count; ++k) {
            links |= passingShare(shares[k]) > 0.5f ? bits[k] : 0u;
        }
        count = 0;
    };
    for (int k = 0; k < 27; ++k) {
        const ivec3 step(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1);
        const ivec3 to = at + step;
        if (step == ivec3(0) || glm::any(glm::lessThan(to, ivec3(0))) ||
            glm::any(glm::greaterThanEqual(to, lattice_.counts))) {
            continue;
        }
        const vec3 way = lattice_.middle(to) - middle;
        const float length = glm::length(way);
        ways[count] = {.start = middle, .direction = way / length, .length = length};
        bits[count] = hintLink(step);
        if (++count == Tracer::kPacket) {
            ask();
        }
    }
    ask();
}

std::array<vec3, 4> HintGrid::kernel(const Place& place) const {
    const mat3 frame = tangentFrame(place.n);
    const vec3 middle = above(place);
    constexpr float kAside = 0.5f * 0.70710678f;
    std::array<vec3, 4> points;
    for (size_t k = 0; k < points.size(); ++k) {
        const vec3 aside = (k % 2 == 0 ? frame[0] : -frame[0]) + (k < 2 ? frame[1] : -frame[1]);
        points[k] = middle + kAside * lattice_.cell * aside;
    }
    return points;
}

// The nearest hint above each surface is asked first, then the next ones.
std::array<int, Tracer::kPacket> HintGrid::anchors(std::span<const Place> places) const {
    constexpr size_t kTries = 8;
    struct Candidate {
        float score;
        int hint;
    };
    std::array<std::array<Candidate, 8>, Tracer::kPacket> candidates;
    std::array<int, Tracer::kPacket> found;
    found.fill(kUnseen);
    for (size_t i = 0; i < places.size(); ++i) {
        const Place& place = places[i];
        const vec3 c = lattice_.nearestCoordinates(above(place));
        const ivec3 base = lattice_.below(c);
        for (int corner = 0; corner < 8; ++corner) {
            const ivec3 at = glm::min(base + ivec3(corner & 1, corner >> 1 & 1, corner >> 2),
                                      lattice_.counts - 1);
            const vec3 way = lattice_.middle(at) - place.position;
            const bool above = glm::dot(way, place.n) > 0.0f;
            const vec3 off = vec3(at) - c;
            candidates[i][static_cast<size_t>(corner)] = {
                glm::dot(off, off) + (above ? 0.0f : kInfinity), lattice_.index(at)};
        }
        std::sort(candidates[i].begin(), candidates[i].end(),
                  [](const Candidate& a, const Candidate& b) {
                      return a.score != b.score ? a.score < b.score : a.hint < b.hint;
                  });
    }
    for (size_t t = 0; t < kTries; ++t) {
        std::array<Way, Tracer::kPacket> ways{};
        bool any = false;
        for (size_t i = 0; i < places.size(); ++i) {
            if (found[i] == kUnseen && candidates[i][t].score < kInfinity) {
                const vec3 way =
                    lattice_.middle(lattice_.at(candidates[i][t].hint)) - places[i].start;
                const float length = glm::length(way);
                ways[i] = {.start = places[i].start, .direction = way / length, .length = length};
                any = true;
            }
        }
        if (!any) {
            break;
        }
        const Tracer::Shares shares = tracer_.passing({ways.data(), places.size()});
        for (size_t i = 0; i < places.size(); ++i) {
            if (ways[i].length > 0.0f && passingShare(shares[i]) > 0.5f) {
                found[i] = candidates[i][t].hint;
            }
        }
    }
    return found;
}

}  // namespace sheen
