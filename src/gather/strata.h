// What the rays of a record met, kept so that its light can be followed from frame to frame without
// them: each ray stands for a stratum of its hemisphere, which is tied to an anchor.
// Based on: [SKDM05].
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "gather/anchors.h"
#include "gather/integrate.h"
#include "gather/texel_rays.h"

namespace sheen {

/// In the order of texels, the first ray of each, then the others, texel by texel.
struct Strata {
    // Strata that are tied to no anchor.
    static constexpr uint32_t kBelow = ~0u;        ///< not cast: below the surface
    static constexpr uint32_t kTraced = ~0u - 1;   ///< traced anew in every frame
    static constexpr uint32_t kNothing = ~0u - 2;  ///< met nothing: the sky, which stays
    static constexpr uint32_t kFirstOther = kNothing;

    RecordSite site = {};                ///< without contrasts
    vec3 eye{0.0f};                      ///< where the rays start
    int side = 0;                        ///< of the hemisphere, texels
    std::vector<uint8_t> more = {};      ///< [texel]: rays besides the first
    std::vector<uint32_t> anchors = {};  ///< or one of the above
    std::vector<float> distances = {};   ///< of what was met; infinite: nothing
    std::vector<vec3> tints = {};        ///< of anchors, the sky's radiance; empty: all are 1

    const vec3& tint(size_t ray) const;
    void setTint(size_t ray, const vec3& tint);
};

/// Rays of one record that were cast in this frame, and what they met.
struct MetByRays {
    std::vector<uint32_t> strata;  ///< of its strata
    std::vector<Anchors::Met> met;
    std::vector<vec4> seen;          ///< radiance; w: distance
    std::vector<vec3> planes;        ///< as Tracer::meet() has them
    std::vector<uint8_t> by_movers;  ///< or hidden by what moves: tied to nothing
    size_t tied = 0;                 ///< so many of these are already
    std::vector<vec4> first;         ///< likewise, of the first ray of each texel; empty: not known
};

/// Rays of a record, and what they met and saw.
struct CastRays {
    const TexelRays& rays;
    std::span<const Hit> hits;
    std::span<const vec4> seen;
    std::span<const vec3> planes = {};  ///< empty: not asked for
};

/// Strata of a record that was gathered, all of them traced so far; `met`: by which rays.
Strata makeStrata(const Hemisphere& h, const RecordSite& site, std::vector<uint8_t> more,
                  std::span<const CastRays> rays, const Movers& movers, MetByRays& met);

struct LightForRays {
    const OutgoingLight& light;
    bool without_caustics = false;
};

/// Casts the rays of strata that must be traced anew: those that were in the frame before, those
/// whose anchor stands no more, and those that something that moves hides.
MetByRays traceChanged(const Hemisphere& h, const LightForRays& by, const Anchors& anchors,
                       Strata& strata);

/// Casts more rays, from now on, through texels within which light has come to change as anchors
/// and what was met in this frame say.
void lookCloser(const Hemisphere& h, const LightForRays& by, const Anchors& anchors, Strata& strata,
                MetByRays& met);

/// Ties strata to what their rays met, of all records in order. Traced ones stay so where something
/// that moves was met, or there are too many anchors. Of what is tied the light is yet to be found.
void tie(const Scene& scene, Anchors& anchors, std::span<Strata* const> strata,
         std::span<MetByRays> met);

/// What the texels see. `met`: of strata that were traced in this frame; its `first` is taken.
SeenTexels texelsOf(const Anchors& anchors, const Strata& strata, MetByRays& met);

/// Drops anchors that no stratum is tied to.
void dropUnused(Anchors& anchors, std::span<Strata* const> strata);

}  // namespace sheen
