// Points of surfaces that the lights shine on, and what leaves them: the texels of reflective
// shadow maps that are sampled, found by rays from the lights instead of by drawing the maps.
// Based on: [Pap11], [DS05].
#pragma once

#include <vector>

#include "light/scene_lights.h"
#include "light/sky.h"

namespace sheen {

/// A piece of surface that one ray from a light stands for.
struct LitSample {
    vec3 position;   ///< where rays leave it, on the lit side
    vec3 n_g;        ///< unit, on that side
    vec3 received;   ///< from the light, lm
    uint32_t group;  ///< neighbours are a group; the same where the light's place is another
    vec3 wi;         ///< unit, toward the light
    float light_distance;
    Scatterer surface;
    float softening2;  ///< its area over pi, as it counts from nearby
    bool glossy;       ///< it has a lobe

    /// Radiance times area toward the unit direction wo, from a point at the squared distance d2
    /// that stands for others around it, `width` across: lobes are as wide as that, and the piece,
    /// is seen.
    vec3 toward(const vec3& wo, float d2, float width) const;
};

/// A sky as hints ask it: by directions that are evenly spread, where it is of one colour, or by
/// its brightness. The environment must outlive it.
class SkySamples {
  public:
    explicit SkySamples(const Environment& environment);

    static constexpr int kCount = 256;
    bool empty() const { return environment_.empty(); }

    struct Sample {
        vec3 wi;     ///< unit, away from the scene
        vec3 light;  ///< radiance times the solid angle that the direction stands for
    };
    /// Of kCount samples the one of that index. Who asks turns or, in [0, 1)^2, shifts all of them,
    /// so that neighbours do not ask the same.
    Sample at(int index, const mat3& rotation, const vec2& shift) const;

  private:
    const Environment& environment_;
    std::vector<vec3> even_;  // of a sky of one colour
    SkySampler sampler_;
};

/// About `count` samples in all, shared among punctual lights and lamps by their power; fewer
/// where rays meet nothing. A light's samples lie in directions that are fixed about it, so that
/// they move as it moves. The same for any number of threads.
std::vector<LitSample> litSamples(const Tracer& tracer, const SceneLights& lights, int count);

}  // namespace sheen
