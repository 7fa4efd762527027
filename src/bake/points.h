// Light at points of surfaces that someone asks for, by the records that a lightmap's texels would
// get.
#pragma once

#include <span>
#include <vector>

#include "bake/bake.h"

namespace sheen {

struct AskedPoint {
    vec3 position;  ///< world space
    vec3 normal;    ///< unit, on the side whose light is asked for
    /// What the point stands for, scene units: about as far as its neighbours lie. The nearest
    /// surface within it along the normal, either way, is the one that is meant.
    float width = 0.0f;
};

struct LightAtPoints {
    std::vector<vec3> direct, indirect;  ///< irradiance, lux, [point]; zero where none is found
    std::vector<uint8_t> found;          ///< [point]: whether a surface is there
    BakeStats stats;
};

/// Irradiance about the surface's smooth normal. `params.method`: by records or at every point. The
/// same bits for any number of threads.
LightAtPoints lightAtPoints(const Tracer& tracer, std::span<const AskedPoint> points,
                            const BakeParams& params);

}  // namespace sheen
