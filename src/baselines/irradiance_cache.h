// The yardstick of the cached methods: irradiance caching as it was before graphics hardware, on
// the CPU, with an octree. Of the rest of the program it shares the scene, the BRDF and the rays
// that judge it (reference/), and nothing of the cache.
// Based on: [WRC88], [WH92], [KBPZ06], [GKB09, sec. 8.1].
#pragma once

#include "baselines/ward_octree.h"

namespace sheen {

struct IrradianceCacheParams {
    int width = 512;
    int height = 512;
    Camera camera;
    /// Ward's a, the largest error a record is reused at. Limits of a record's reach and the number
    /// of its rays follow from it, so that each share of the error falls with the others.
    float accuracy = 0.4f;
    /// Rings of a record's hemisphere, which takes about pi times their square of rays; 0: as many
    /// as suit the accuracy.
    int rings = 0;
    bool quiet = false;  ///< no progress
};

struct IrradianceCacheResult {
    /// All layers; indirect light is the diffuse part alone, whatever the material.
    Frame frame;
    int records = 0;
    int uncovered = 0;  ///< pixels that see geometry and are served by no record
    int64_t rays = 0;
    int64_t nonfinite_samples = 0;
    // Wall-clock seconds.
    double see = 0.0;          ///< building the acceleration structure, primary and shadow rays
    double place = 0.0;        ///< first pass without:
    double gather = 0.0;       ///< what its records see
    double interpolate = 0.0;  ///< second pass
};

/// Renders in two passes: the first fills the cache, the second asks it at every pixel. The same
/// bits for any number of threads. Environment error where Embree fails.
IrradianceCacheResult renderIrradianceCache(const Scene& scene,
                                            const IrradianceCacheParams& params);

}  // namespace sheen
