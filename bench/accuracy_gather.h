// The gathers that benches judge and time: the program's, at points that stand for records of a
// render, and the yardstick's, which is the octree baseline's.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "baselines/ward_record.h"
#include "gather/ray_gather.h"

namespace sheen::bench {

constexpr size_t kBatch = 64;  ///< records gathered at once, as PlacementParams::batch

/// Gathers in batches of a placement's size; one record a site, in order.
std::vector<GatheredRecord> gatherInBatches(RayGatherer& gatherer,
                                            std::span<const RecordSite> sites);

/// Gathers at all sites and tells each what its three nearest found, as records that come after
/// others in a render know it.
void tellContrasts(RayGatherer& gatherer, std::span<RecordSite> sites);

/// What the yardstick finds: an irradiance a site, in order.
struct YardstickRecords {
    std::vector<vec3> irradiance;
    int64_t rays = 0;  ///< cast, shadow rays included
};
YardstickRecords gatherByYardstick(const RayScene& rays, std::span<const RecordSite> sites,
                                   const WardStrata& strata);

}  // namespace sheen::bench
