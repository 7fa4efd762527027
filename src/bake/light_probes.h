// Light probes: the light around points of a lattice in the air, for things that move among baked
// ones.
#pragma once

#include <vector>

#include "bake/bake.h"
#include "gather/light_around.h"
#include "hints/hint_grid.h"

namespace sheen {

/// Bands of a light probe: what irradiance asks for, within 1% of its mean [RH01].
constexpr int kLightProbeOrder = 3;
constexpr int kMostLightProbes = 1 << 20;

/// The middles of so many equal cells of a box. Usage error where there are more than
/// kMostLightProbes.
HintLattice lightProbeLattice(const Bounds& box, const ivec3& counts);
/// Of as many cells as put them no farther apart than `spacing`, scene units. Usage error likewise.
HintLattice lightProbeLattice(const Bounds& box, float spacing);

struct LightProbes {
    /// [HintLattice::index()]: kLightProbeOrder bands. Those within solids have the light of the
    /// free ones around them.
    std::vector<ShLight> light;
    std::vector<uint8_t> solid;  ///< likewise: whether it lies within something solid (solids.h)
    int free = 0;                ///< that do not
    BakeStats stats;
};

/// Light of all kinds that arrives there, or, by BakeParams::indirect_only, without what comes
/// straight from lights and lamps. By records alone. The same bits for any number of threads and
/// ranks; on the first, which the others serve (serveBake()).
LightProbes bakeLightProbes(const Tracer& tracer, const HintLattice& lattice,
                            const BakeParams& params, const RankedJob& job = {});

}  // namespace sheen
