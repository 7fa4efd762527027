// Rays that find surfaces, and ways that are free: no light. The reference has rays of its own
// (reference/ray_scene.h): were they these, a mistake here would go unseen by what judges it.
// Based on: [WWB14].
#pragma once

#include <embree3/rtcore.h>

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "scene/scene.h"

namespace sheen {

/// Rays from one point, or each from its own. Neighbours should point in similar directions.
struct Rays {
    vec3 origin{0.0f};
    std::span<const vec3> directions;  ///< unit
    /// Of the cone a ray stands for, as many as directions. Highlights narrower than it are seen as
    /// wide as it is (filteredAlpha() in brdf.glsl). None: each ray stands for itself.
    std::span<const float> solid_angles = {};
    std::span<const vec3> origins = {};  ///< as many as directions; none: all start at `origin`
    /// Of which set, below kSets, a ray is, as many as directions; none: all of set 0. What rays of
    /// one origin and one set meet draws its chance from one evenly spread sequence; sets know
    /// nothing of each other, as those must that decide how much each other's rays count.
    std::span<const uint8_t> sets = {};
    static constexpr size_t kSets = 16;
    /// What specular surfaces alone make of lights does not count: it is kept apart (caustics.h).
    bool without_caustics = false;

    const vec3& originOf(size_t i) const { return origins.empty() ? origin : origins[i]; }
    size_t setOf(size_t i) const { return sets.empty() ? 0 : sets[i]; }
    float solidAngle(size_t i) const { return solid_angles.empty() ? 0.0f : solid_angles[i]; }
    /// `count` of them from `first` on.
    Rays part(size_t first, size_t count) const {
        return {.origin = origin,
                .directions = directions.subspan(first, count),
                .solid_angles =
                    solid_angles.empty() ? solid_angles : solid_angles.subspan(first, count),
                .origins = origins.empty() ? origins : origins.subspan(first, count),
                .sets = sets.empty() ? sets : sets.subspan(first, count),
                .without_caustics = without_caustics};
    }
};

/// What a ray meets first: a triangle, and there the barycentric coordinates of its second and
/// third vertex.
struct Hit {
    static constexpr uint32_t kNothing = ~0u;
    uint32_t triangle = kNothing;
    float u = 0, v = 0;
    float distance = kInfinity;
    bool back = false;  ///< met from the triangle's back
    /// What light that comes from there counts: less, or more in one channel than in another, where
    /// the ray passed glass. Of what is not met, too: the sky shines through glass.
    vec3 weight{1.0f};

    bool found() const { return triangle != kNothing; }
};

/// The way from a surface to a light, as far as something could hide it. Of length 0: not asked.
struct Way {
    vec3 start{0.0f};
    vec3 direction{0.0f};  ///< unit
    float length = 0.0f;
};

/// What a camera's ray sees: surfaces that let a part of the light pass, from the eye on, and what
/// lies behind them, which may be nothing. Bodies of glass bend it (refraction.h).
struct Sight {
    /// One before the ground that lets less light pass than shows, or the one after so many, is
    /// taken as that.
    static constexpr int kMostVeils = 8;
    /// So often it is bent; from there it goes straight on.
    static constexpr int kMostBends = 16;
    struct Part {
        Hit hit;
        vec3 share{0.0f};  ///< of the light that leaves it, what reaches the eye
        // Of the ray where it sees this, which glass may have bent before.
        vec3 origin{0.0f};
        vec3 direction{0.0f};
        float before = 0.0f;  ///< how far it travelled to that origin
        /// Of a body of glass that the ray is leaving there, the cosine outside; 0: of no such.
        float leaving = 0.0f;

        bool bent() const { return before > 0.0f; }
    };
    std::array<Part, kMostVeils> veils;
    int veil_count = 0;
    Part ground{.hit = {}, .share = vec3(1.0f)};

    /// The ground for 0, else the veil of that number; nothing where there are not so many.
    Part part(int veil) const {
        return veil == 0            ? ground
               : veil <= veil_count ? veils[static_cast<size_t>(veil - 1)]
                                    : Part{};
    }
};

/// Traces rays in a scene, which must outlive it. Safe to use from many threads.
class Tracer {
  public:
    /// Environment error where Embree cannot start or runs out of memory.
    explicit Tracer(const Scene& scene);

    const Scene& scene() const { return scene_; }

    /// Rays that meet the scene together.
    static constexpr int kPacket = 8;

    /// What each ray meets, kPacket rays at a time; what lets a part of the light pass it meets by
    /// Crossing::chance, by a hash of the point, and counts by the weights of that. As many `hits`
    /// as rays. `planes`, where given, get those of the triangles met: along a unit direction d
    /// from the origin, a plane lies at distance 1 / dot(plane, d); zero where nothing is met.
    void meet(const Rays& rays, Hit* hits, vec3* planes = nullptr) const;

    /// What a camera's ray sees: it passes the backs of single-sided materials. Cast alone: which
    /// of two triangles owns a ray through their common edge differs by how many are cast together.
    /// `lobe`: where in what rough glass makes of a ray this one goes, in [0, 1)^2; none: as if all
    /// glass were smooth.
    Sight seeAlone(const vec3& origin, const vec3& direction,
                   const std::optional<vec2>& lobe = {}) const;

    /// What share of light passes on each of at most kPacket ways, channel by channel; 0 where not
    /// asked.
    using Shares = std::array<vec3, kPacket>;
    Shares passing(std::span<const Way> ways) const;

  private:
    struct ReleaseDevice {
        void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
    };
    struct ReleaseScene {
        void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
    };
    void build();
    Hit meetAlone(const vec3& origin, const vec3& direction, float from, float to) const;
    vec3 passingVeils(const Way& way) const;
    vec3 weightOf(const vec3& origin, const vec3& direction, const Hit& hit) const;

    const Scene& scene_;
    std::unique_ptr<RTCDeviceTy, ReleaseDevice> device_;
    std::unique_ptr<RTCSceneTy, ReleaseScene> embree_;
};

}  // namespace sheen
