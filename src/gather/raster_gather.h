// Gathering by rasterising the scene around each record.
// Based on: [GKB09, 8.4].
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "gather/integrate.h"
#include "raster/gpu_scene.h"

namespace sheen {

/// Gathers on all workers of a pool at once; the results do not depend on how many there are. The
/// GPU scene needs its shadow maps.
class RasterGatherer : public Gatherer {
  public:
    RasterGatherer(gl::WorkerPool& pool, const GpuScene& gpu, const HemisphereParams& params);
    ~RasterGatherer() override;

    std::vector<GatheredRecord> gather(std::span<const RecordSite> sites) override;

  private:
    struct Worker;
    struct Drawn;
    void see(std::span<const RecordSite> sites);
    void upload(Worker& w, std::span<const RecordSite> batch) const;
    void draw(Worker& w, int records) const;
    void readBack(const Worker& w, int records, Drawn& drawn) const;
    void seenBy(std::span<const RecordSite> sites, size_t index, SeenTexels& seen) const;

    gl::WorkerPool& pool_;
    const GpuScene& gpu_;
    Hemisphere hemisphere_;
    float lod_tolerance_ = 0;  // radians
    ProjectionMatrices projections_;
    std::vector<std::unique_ptr<Worker>> workers_;
    std::vector<Drawn> drawn_;      // a batch
    std::vector<SeenTexels> seen_;  // a record of these batches
};

}  // namespace sheen
