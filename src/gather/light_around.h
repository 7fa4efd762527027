// Light around a point as spherical harmonics, whoever or whatever is lit by it: what records and
// direct light are to a surface whose normal is not known.
#pragma once

#include <span>
#include <vector>

#include "gather/gatherer.h"
#include "light/scene_lights.h"

namespace sheen {

/// Coefficients of radiance, nits, [l (l + 1) + m] of the basis that sh/sh.h has, world space.
using ShLight = std::vector<vec3>;

/// What arrives at each point in the air from all around by what rays meet, of `order` bands: of
/// two records, one that looks up and one that looks down. `gatherer` must have records that say
/// nothing of what is below their horizon (BelowHorizon::kNothing).
std::vector<ShLight> gatherAround(Gatherer& gatherer, std::span<const vec3> points, int order);

/// What arrives straight from lights and lamps at a point: from above the surface's side that it
/// lies on, or, where `radius` is above 0, from all around a point in the air that stands for as
/// much: punctual lights that are nearer count as if they were that far off. They are asked one by
/// one; lamps by samples, whose random numbers `seed` decides.
ShLight directAround(const Tracer& tracer, const SceneLights& lights, const SurfaceSide& point,
                     float radius, int order, uint32_t seed);

}  // namespace sheen
