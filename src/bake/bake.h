// Baking: the irradiance of a lightmap's texels. Records lie on surfaces and serve texels of all
// charts and objects around, so that these agree.
// Based on: [Cas11] for records at few of the texels, [WRC88], [WH92].
#pragma once

#include "bake/lightmap.h"
#include "core/bounces.h"
#include "core/ranks.h"
#include "gather/gather_log.h"
#include "image/frame.h"

namespace sheen {

enum class BakeMethod {
    kRecords,    ///< gathered at some texels, interpolated at the others
    kTexels,     ///< the same gather at every texel: what records save time over
    kReference,  ///< every texel path-traced, with its variance
};

struct BakeParams {
    BakeMethod method = BakeMethod::kRecords;
    float accuracy = 0.4f;  ///< Ward's a; by records and texels, how finely each looks
    int bounces = kAllBounces;
    bool indirect_only = false;  ///< without the light straight from lights and lamps
    /// Also where light comes from (Baked::sh); by records and texels.
    bool directional = false;
    int spp = 1024;     ///< of the reference
    uint32_t seed = 0;  ///< likewise
    bool quiet = false;
    /// What was gathered is kept there, and taken from there; null: nowhere. Of records and texels.
    GatherLog* log = nullptr;
};

struct BakeStats {
    int records = 0;    ///< hemispheres gathered
    int uncovered = 0;  ///< texels that no record serves: 0 where numbers are sound
    int spp = 0;        ///< paths a texel of the reference, rounded up to whole replicates
    double seconds_lights = 0, seconds_direct = 0, seconds_place = 0, seconds_gather = 0,
           seconds_interpolate = 0, seconds_trace = 0;
};

/// Bands of what is baked of the directions that light comes from: the second one's coefficients,
/// times sqrt(4 pi / 3), are the vector whose cosine-weighted part along a normal is its irradiance
/// as long as no light is below it.
constexpr int kDirectionalOrder = 2;

struct Baked {
    /// Layers of irradiance, lux, [texel]: direct (black where it is not asked for) and indirect,
    /// of the reference with their variances; filled up all over (dilate.h). `primitive` tells the
    /// texels that have light of their own: the others show kNoPrimitive and are not compared.
    Frame frame;
    /// [coefficient], texels: radiance from above each, direct and indirect, world space, nits;
    /// filled up likewise. Empty unless BakeParams::directional.
    std::vector<Image<vec3>> sh;
    BakeStats stats;
};

/// What a page of the atlas has of it.
Baked pageOf(const Atlas& atlas, const Baked& baked, int page);

/// The light of receivers of a lightmap's kind (texels.h), by records or at each: the layers
/// direct, unless only the indirect is asked for, and indirect, and `sh` where it is asked for. Of
/// a shared job on the first rank; the others serve it (serveBake()).
Baked gatherLight(const Tracer& tracer, const Receivers& receivers, const BakeParams& params,
                  const RankedJob& job = {});

/// On other ranks than the first: gathers what a bake there, of this scene and these parameters,
/// asks for, by the light that it has found, until it ends.
void serveBake(const Tracer& tracer, const BakeParams& params, const RankedJob& job);

/// Usage error for what the reference has none of, and for a reference of several ranks. The same
/// bits for any number of threads and ranks; likewise on the first rank.
Baked bake(const Tracer& tracer, const Lightmap& map, const BakeParams& params,
           const RankedJob& job = {});

}  // namespace sheen
