// Gathering by rasterising the scene around each record.
// Based on: [GKB09, 8.4].
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "cache/gather.h"
#include "raster/gpu_scene.h"

namespace sheen {

/// Gathers on all workers of a pool at once; the results do not depend on how many there are. The
/// GPU scene needs its surfaces lit.
class RasterGatherer {
  public:
    RasterGatherer(gl::WorkerPool& pool, const Scene& scene, const GpuScene& gpu,
                   const HemisphereParams& params);
    ~RasterGatherer();

    /// One result a site, in order.
    std::vector<GatheredRecord> gather(std::span<const RecordSite> sites);

    /// Time spent so far, as an average over the workers.
    GatherSeconds seconds() const;

  private:
    struct Worker;
    void upload(Worker& w, std::span<const RecordSite> batch) const;
    void draw(Worker& w, int records) const;
    void readBack(Worker& w, int records) const;
    void integrate(Worker& w, std::span<const RecordSite> batch, GatheredRecord* results) const;

    gl::WorkerPool& pool_;
    const GpuScene& gpu_;
    Hemisphere hemisphere_;
    float near_ = 0;
    float lod_tolerance_ = 0;  // radians
    float lift_ = 0;  // from the surface, so that rounding never puts it in front of the eye
    bool any_shaded_ = false;  // whether some surface is not Lambertian
    ProjectionMatrices projections_;
    std::vector<std::unique_ptr<Worker>> workers_;
};

}  // namespace sheen
