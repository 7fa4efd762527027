// Gathering: what light arrives at a record, by rasterising the scene around it.
// Based on: [GKB09, 8.4], [WH92] for the gradients.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "cache/record.h"
#include "hemisphere/hemisphere.h"
#include "raster/gpu_scene.h"

namespace sheen {

struct GatherSeconds {
    double raster = 0;   ///< drawing, shading and reading back
    double project = 0;  ///< sums, gradients, spherical harmonics
};

/// Gathers on all workers of a pool at once; the results do not depend on how many there are.
class Gatherer {
  public:
    Gatherer(gl::WorkerPool& pool, const Scene& scene, const GpuScene& gpu,
             const HemisphereParams& params);
    ~Gatherer();

    /// One result a site, in order.
    std::vector<GatheredRecord> gather(std::span<const RecordSite> sites);

    /// Wall-clock time spent so far, as an average over the workers.
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
    bool any_shaded_ = false;                     // whether some surface is not Lambertian
    std::vector<std::vector<float>> projection_;  // [order]; made when first needed
    std::vector<std::unique_ptr<Worker>> workers_;
};

/// Radiance and distance of a record's texels, as read back: RGB and w (0: nothing seen).
/// Turns them into a record: irradiance, gradients, harmonic mean distance and, for order > 0,
/// spherical harmonics through `projection` (of that order).
GatheredRecord integrateHemisphere(const Hemisphere& hemisphere, std::span<const vec4> texels,
                                   const std::vector<float>& projection, const RecordSite& site);

}  // namespace sheen
