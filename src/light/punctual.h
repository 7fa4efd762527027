// Light that arrives straight from punctual lights.
#pragma once

#include <cstdint>
#include <span>

#include "rays/surface_point.h"
#include "rays/tracer.h"

namespace sheen {

/// The way to a light from a start off a surface, where it arrives as `sample`.
Way wayTo(const PunctualLight& light, const LightSample& sample, const vec3& start);

/// Which of at most Tracer::kPacket points get light from `light` on the side of n_g: bit k is the
/// k-th one's.
uint32_t reached(const Tracer& tracer, const PunctualLight& light,
                 std::span<const SurfaceSide> points);

}  // namespace sheen
