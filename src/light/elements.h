// Points spread over surfaces, at which something that varies smoothly along them is kept, and how
// it is interpolated between them.
// Based on: [WRC88] for the weights; what hides a point from an element's neighbourhood is what the
// element's own rays met.
#pragma once

#include <array>
#include <cmath>
#include <cstdint>
#include <vector>

#include "core/bytes.h"
#include "rays/surface_point.h"

namespace sheen {

/// Where an element lies, or may lie.
struct ElementSite {
    SurfaceSide side;
    vec3 normal;        ///< smooth shading normal, unit, on that side
    float spacing = 0;  ///< to the next one that there should be
};

/// Safe to read from many threads.
class Elements {
  public:
    /// How far an element counts, over its spacing.
    static constexpr float kReach = 1.5f;
    /// Around its normal an element knows the way to what stands on its surface by so many sectors.
    static constexpr int kSectors = 8;
    using Ways = std::array<float, kSectors>;

    Elements() = default;
    /// As another process wrote them.
    explicit Elements(ByteReader& in);
    void write(ByteWriter& out) const;

    size_t size() const { return elements_.size(); }
    const ElementSite& site(size_t i) const { return elements_[i].site; }

    /// Whether there should be one more: none that counts there is closer than its own spacing.
    bool lacks(const ElementSite& site) const;
    void add(const ElementSite& site);
    /// Of element i: in its plane nothing stands nearer than `free`, by sector(), and others should
    /// lie no farther off than `spacing`. Counts for all of it from reindex() on.
    void know(size_t i, const Ways& free, float spacing);
    void reindex();
    /// That of a direction from the element.
    size_t sector(size_t i, const vec3& direction) const { return elements_[i].sector(direction); }
    /// That of a direction from an element whose normal has this tangentFrame(). Of eight that are
    /// evenly spread from half of their angle on, each has one.
    static size_t sector(const mat3& frame, const vec3& direction);

    /// Calls body(element, weight) for those that say something of a point with the unit normal n,
    /// weights above 0, not normalised.
    template <class F>
    void around(const vec3& p, const vec3& n, const F& body) const {
        forEachAround(p, [&](size_t i) {
            const float weight = elements_[i].weight(p, n);
            if (weight > 0.0f) {
                body(i, weight);
            }
        });
    }

  private:
    static constexpr uint32_t kNone = ~0u;

    struct Element {
        ElementSite site;
        mat3 frame;  // tangentFrame() of the normal
        Ways free;

        size_t sector(const vec3& d) const { return Elements::sector(frame, d); }
        float weight(const vec3& p, const vec3& n) const;
    };
    // A voxel's elements are a list in links_; voxels, of sizes that are powers of two, are found
    // by open addressing.
    struct Voxel {
        uint64_t key = 0;
        uint32_t first = kNone;  // link; kNone: the slot is free
    };
    // What most elements of a voxel are told by that they do not reach a point.
    struct Link {
        vec3 position;
        float reach2;
        uint32_t element, next;
    };
    struct Level {
        int level;    // of voxels that there are: their size is 2^level
        float scale;  // 2^-level
    };
    void index(size_t i);
    static uint64_t keyOf(int level, const vec3& scaled);
    size_t slotOf(uint64_t key) const;
    void enter(uint64_t key, const Link& link);
    void sortLinks();

    // Those that reach as far as p, at least.
    template <class F>
    void forEachAround(const vec3& p, const F& body) const {
        for (const Level& level : levels_) {
            const Voxel& voxel = voxels_[slotOf(keyOf(level.level, p * level.scale))];
            for (uint32_t i = voxel.first; i != kNone; i = links_[i].next) {
                const Link& link = links_[i];
                const vec3 d = p - link.position;
                if (glm::dot(d, d) < link.reach2) {
                    body(link.element);
                }
            }
        }
    }

    std::vector<Element> elements_;
    std::vector<Level> levels_;
    std::vector<Voxel> voxels_ = std::vector<Voxel>(64);
    size_t filled_ = 0;
    std::vector<Link> links_;
};

}  // namespace sheen
