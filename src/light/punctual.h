// Light that arrives straight from punctual lights.
#pragma once

#include <cstdint>
#include <span>

#include "rays/surface_point.h"
#include "rays/tracer.h"

namespace sheen {

/// The way to a light from a start off a surface, where it arrives as `sample`.
Way wayTo(const PunctualLight& light, const LightSample& sample, const vec3& start);

/// What share of the light of `light` each of at most Tracer::kPacket points gets on the side of
/// n_g.
Tracer::Shares reaching(const Tracer& tracer, const PunctualLight& light,
                        std::span<const SurfaceSide> points);

}  // namespace sheen
