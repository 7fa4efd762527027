// Anchors: points on surfaces that stand still, to which what the rays of records met is tied.
// Their light is found anew in every frame, once for all rays that are tied to them. Based on:
// [SKDM05]. There it is the density of photons around an anchor; here it is what a ray that meets
// it sees, lights' by shadow rays and all bounces' by the light kept on surfaces.
#pragma once

#include <cstdint>
#include <optional>
#include <unordered_map>
#include <vector>

#include "gather/movers.h"
#include "light/outgoing.h"

namespace sheen {

/// find() is safe to use from many threads.
class Anchors {
  public:
    /// So many there are at the most.
    static constexpr size_t kMost = size_t{1} << 22;
    /// So many rays may be tied to them: 8 bytes each, or 20 where some have tints.
    static constexpr size_t kMostRays = size_t{1} << 26;

    /// Begins a frame, in which triangles move as `moves` says: [triangle], 1 where one has moved
    /// since the frame before or will until the next; empty: none. The scene's triangles are those
    /// of the frame before, when its vertices were at `before`; empty: where they are. What lies on
    /// one that moves is no anchor any more. `rays`: so many are tied to anchors.
    void beginFrame(const Scene& scene, std::vector<uint8_t> moves, std::span<const vec3> before,
                    size_t rays);
    /// Whether so many more may be, which counts them.
    bool claim(size_t rays);
    const Movers& movers() const { return movers_; }

    /// What a ray met.
    struct Met {
        vec3 origin{0.0f};
        vec3 direction{0.0f};
        float solid_angle = 0.0f;  ///< that the ray stands for
        Hit hit = {};
    };
    /// A ray's light is the anchor's, times the tint: by how much more what it met reflects.
    struct Link {
        uint32_t anchor = 0;
        vec3 tint{1.0f};
    };
    /// The anchor of a surface that a ray met, which stands still: one in the same cell of space,
    /// as large as what the ray stands for, whose normal and reflection agree. None where none is.
    std::optional<Link> find(const Scene& scene, const Met& met) const;
    /// The same, and a new one where none is; none where there are too many.
    std::optional<Link> findOrAdd(const Scene& scene, const Met& met);

    /// Finds the light of all, unless it has been in this frame, or of those added since.
    void lightBy(const OutgoingLight& light, bool without_caustics);

    size_t size() const { return places_.size(); }
    /// Whether something moves, or some anchor's light is not that of the frame before.
    bool change() const { return change_; }
    /// False where its surface moves.
    bool stands(uint32_t anchor) const { return stands_[anchor] != 0; }
    /// Radiance toward the rays that are tied to it.
    const vec3& light(uint32_t anchor) const { return light_[anchor]; }
    struct Point {
        vec3 position{0.0f};
        vec3 normal{0.0f};  ///< geometric, on the side that is seen
    };
    const Point& point(uint32_t anchor) const { return surfaces_[anchor].point; }

    static constexpr uint32_t kNone = ~0u;
    /// Drops all but those `used`, [anchor], that stand. Returns what becomes of each, [anchor]: a
    /// new index, or kNone.
    std::vector<uint32_t> keepOnly(std::span<const uint8_t> used);

  private:
    // What decides whether two points may share an anchor.
    struct Surface {
        Point point = {};
        vec3 toward{0.0f};  // unit, to who sees it
        vec3 color{0.0f};   // what it reflects, over its material's
        vec3 emission{0.0f};
        float alpha = 0.0f;  // of its lobe; 0: it has none
        uint32_t material = 0;
        uint64_t cell = 0;
    };
    static Surface surfaceOf(const Scene& scene, const Met& met);
    static std::optional<vec3> tintOf(const Surface& anchor, const Surface& met);
    std::optional<Link> findFor(const Surface& surface, const vec3& weight) const;
    void insert(uint32_t anchor);

    Movers movers_;
    // [anchor]
    std::vector<Met> places_;
    std::vector<Surface> surfaces_;
    std::vector<uint8_t> stands_;
    std::vector<vec3> light_;
    std::vector<uint32_t> next_;                       // of the same cell
    std::unordered_map<uint64_t, uint32_t> first_of_;  // [cell]: anchor
    bool change_ = false;
    size_t rays_ = 0;    // that are tied
    size_t before_ = 0;  // so many, the first, there were in the frame before
    size_t lit_ = 0;     // so many, the first, are lit in this frame
};

}  // namespace sheen
