// Where radiance hints lie: a lattice of cells, a hint in the middle of each; what each sees of the
// scene's geometry, and which of them tell of the light at a point. Nothing here depends on lights.
// Based on: [Pap11].
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "rays/tracer.h"

namespace sheen {

/// So many hints, or packets of points asked of them, are one piece of work for a thread.
constexpr int kHintGrain = 8;

/// A lattice of equal cells, in world space. Two of one origin share cells where the sizes of one
/// are those of the other divided by a power of two.
struct HintLattice {
    vec3 origin{0.0f};
    vec3 cell{1.0f};  ///< sides
    ivec3 first{0};   ///< cell of lattice coordinates that comes first
    ivec3 counts{0};

    int count() const { return counts.x * counts.y * counts.z; }
    int index(const ivec3& at) const { return (at.z * counts.y + at.y) * counts.x + at.x; }
    /// Of the hint of an index: its cell, from 0 on along each axis.
    ivec3 at(int index) const {
        return {index % counts.x, index / counts.x % counts.y, index / (counts.x * counts.y)};
    }
    vec3 middle(const ivec3& at) const { return origin + cell * (vec3(first + at) + 0.5f); }
    /// A point in units of cells, such that hints lie at whole numbers.
    vec3 coordinates(const vec3& p) const { return (p - origin) / cell - vec3(first) - 0.5f; }
    /// The same of the nearest point among hints.
    vec3 nearestCoordinates(const vec3& p) const {
        return glm::clamp(coordinates(p), vec3(0.0f), vec3(counts - 1));
    }
    /// The first of the eight hints around coordinates among hints; where an axis has but one, its
    /// second has weight 0.
    ivec3 below(const vec3& coordinates) const {
        return glm::min(ivec3(coordinates), glm::max(counts - 2, ivec3(0)));
    }
    /// How far a point lies within the outermost hints, in cells; negative: outside.
    float within(const vec3& p) const {
        const vec3 c = coordinates(p);
        const vec3 inner = glm::min(c, vec3(counts - 1) - c);
        return glm::min(inner.x, glm::min(inner.y, inner.z));
    }
};

/// Of about `hints` cells that fill a box, nearly cubes. The box of a flat scene is made thicker.
HintLattice latticeOf(const Bounds& box, int hints);

/// The same for a part of what `whole` covers: its cells are those of `whole`, halved so often that
/// about `hints` fill the box, of whose cells they are a few more. Moving the box moves no cell.
HintLattice latticeWithin(const HintLattice& whole, const Bounds& box, int hints);

/// Whose light is wanted: a point of a surface on the side of the unit normal n.
struct HintPlace {
    vec3 position;
    vec3 n;
    vec3 start;  ///< where rays leave it
};

/// What a hint's ray met: a point that may send light to it.
struct HintLook {
    vec3 position;      ///< where rays leave it
    vec3 n_g;           ///< unit, on the side that is seen; zero: nothing was met
    vec3 albedo{0.0f};  ///< of all that the surface reflects

    bool found() const { return n_g != vec3(0.0f); }
    HintPlace place() const { return {position, n_g, position}; }
};

/// Safe to use from many threads. The tracer must outlive it.
class HintGrid {
  public:
    /// Directions in which a hint looks, evenly spread, turned at random; and points of its cell.
    static constexpr int kLooks = 32;

    HintGrid(const Tracer& tracer, const HintLattice& lattice);
    HintGrid(HintGrid&&) = default;

    const HintLattice& lattice() const { return lattice_; }
    /// A rotation of its own, which follows from the hint's place in the lattice alone.
    mat3 rotationOf(int hint) const;
    /// [look], before its rotation.
    static const std::vector<vec3>& directions();
    /// [look]: points spread over the hint's cell, on its side of whatever stands in it.
    const vec3* pointsOf(int hint) const { return &points_[static_cast<size_t>(hint) * kLooks]; }
    /// [look]
    const HintLook* looksOf(int hint) const { return &looks_[static_cast<size_t>(hint) * kLooks]; }

    using Place = HintPlace;
    static constexpr int kUnseen = -1;
    /// Of each of at most Tracer::kPacket places a hint nearby that sees it, or kUnseen.
    std::array<int, Tracer::kPacket> anchors(std::span<const Place> places) const;

    /// Calls body(hint, weight), weights above 0, for those that tell of the light at a place: by
    /// trilinear weights at `samples`, points above the surface. Those behind the surface count
    /// not, nor do those that `anchor`, which the place sees, does not see. Where that leaves none,
    /// the anchor says all; where the place sees none, all count.
    template <class F>
    void forEachHint(const Place& place, int anchor, std::span<const vec3> samples,
                     const F& body) const;
    /// Of a place: half a cell above it, and four points about that, as far from it.
    vec3 above(const Place& place) const { return place.position + 0.5f * lattice_.cell * place.n; }
    std::array<vec3, 4> kernel(const Place& place) const;

  private:
    uint32_t seedOf(int hint) const;
    void look(int hint);
    void link(int hint);
    bool linked(const ivec3& from, const ivec3& to) const;

    const Tracer& tracer_;
    HintLattice lattice_;
    std::vector<vec3> points_;
    std::vector<HintLook> looks_;
    std::vector<uint32_t> links_;  // [hint]: which of the 26 around it see it
};

/// The bit of a neighbour among links; both differ by at most 1 along each axis.
inline uint32_t hintLink(const ivec3& step) {
    return 1u << static_cast<uint32_t>((step.z + 1) * 9 + (step.y + 1) * 3 + step.x + 1);
}

inline bool HintGrid::linked(const ivec3& from, const ivec3& to) const {
    const ivec3 step = to - from;
    return step == ivec3(0) ||
           (glm::all(glm::lessThanEqual(glm::abs(step), ivec3(1))) &&
            (links_[static_cast<size_t>(lattice_.index(from))] & hintLink(step)) != 0);
}

template <class F>
void HintGrid::forEachHint(const Place& place, int anchor, std::span<const vec3> samples,
                           const F& body) const {
    constexpr float kFull = 0.25f;  // so high above the surface, in cells, a hint counts fully
    const bool blind = anchor == kUnseen;
    const float least = blind ? 0.01f : 0.0f;
    const ivec3 from = lattice_.at(blind ? 0 : anchor);
    const vec3 p = lattice_.coordinates(place.position);
    const vec3 up = place.n * lattice_.cell;
    const float per_height = 1.0f / (kFull * glm::length(up));
    bool any = false;
    for (const vec3& sample : samples) {
        const vec3 c = lattice_.nearestCoordinates(sample);
        const ivec3 base = lattice_.below(c);
        const vec3 f = c - vec3(base);
        for (int corner = 0; corner < 8; ++corner) {
            const ivec3 step(corner & 1, corner >> 1 & 1, corner >> 2);
            const vec3 w = glm::mix(1.0f - f, f, vec3(step));
            const ivec3 at = base + step;
            const float front = glm::clamp(glm::dot(vec3(at) - p, up) * per_height, least, 1.0f);
            const float weight = w.x * w.y * w.z * front;
            if (weight > 0.0f && (blind || linked(from, at))) {
                body(lattice_.index(at), weight);
                any = true;
            }
        }
    }
    if (!any) {
        body(anchor, 1.0f);
    }
}

}  // namespace sheen
