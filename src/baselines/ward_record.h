// A record of the classical irradiance cache: irradiance from one stratified hemisphere of rays,
// how it changes with position and orientation, and how far it may be reused.
// Based on: [WRC88], [WH92].
#pragma once

#include <span>

#include "reference/light.h"

namespace sheen {

struct WardRecord {
    vec3 position{0.0f};     ///< world space
    vec3 normal{0.0f};       ///< shading normal, unit
    float radius = 0.0f;     ///< harmonic mean distance and what limited it; scene units
    vec3 irradiance{0.0f};   ///< lux, per channel; the albedo is not included
    mat3 rotation{0.0f};     ///< [channel]: E(n) = E + (n - normal) . rotation
    mat3 translation{0.0f};  ///< [channel]: E(p) = E + (p - position) . translation

    /// Irradiance at p on a surface of normal n, to first order.
    vec3 extrapolate(const vec3& p, const vec3& n) const {
        return irradiance + (n - normal) * rotation + (p - position) * translation;
    }
};

/// What one ray of a hemisphere met.
struct WardCell {
    vec3 radiance{0.0f};
    float distance = kInfinity;  ///< 0: it points below the geometric surface
};

/// Directions of a hemisphere around z: `rows` rings of equal cosine weight from the zenith to the
/// horizon, each cut into `columns` sectors.
struct WardStrata {
    int rows = 0;
    int columns = 0;  ///< about pi times the rows: cells are about as wide as high [WH92]

    explicit WardStrata(int rows);
    int count() const { return rows * columns; }
    /// Unit; of the place u in [0, 1)^2 within cell [column][row].
    vec3 direction(int column, int row, const vec2& u) const;
};

/// Irradiance, its gradients and the harmonic mean distance of `cells` [column][row], around the
/// third column of world_from_local, at the origin. The radius is at most where the translation
/// gradient would double or cancel the irradiance. [WH92, eqs. 3, 4]
WardRecord integrateCells(const WardStrata& strata, std::span<const WardCell> cells,
                          const mat3& world_from_local);

/// Sees the hemisphere of a surface, one ray through a random place of each cell: light scattered
/// once, and the sky. `seed` chooses the places.
WardRecord gatherRecord(const RayScene& rays, const Lights& lights, const Surface& p,
                        const WardStrata& strata, uint32_t seed, Counters& counters);

}  // namespace sheen
