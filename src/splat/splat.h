// Splatting: every record adds what it contributes to the pixels it serves; the sums divided by the
// sum of weights are the indirect light.
// Based on: [GKB09, 8.1], [GKBP05].
#pragma once

#include <vector>

#include "gl/worker_pool.h"
#include "image/frame.h"
#include "receivers/edges.h"
#include "receivers/receivers.h"
#include "record/record.h"

namespace sheen {

/// Pixels that splatGpu() draws at a time: 100 bytes each, and those of their lobes.
constexpr int kBandPixels = 1 << 21;

/// Sums over the records, an image of receivers.
struct SplatBuffer {
    Image<vec4> irradiance;  ///< weight * irradiance; w: sum of weights
    /// weight * lobe convolved, before Lobes::scale; w: unused. Empty where no pixel has a
    /// lobe.
    Image<vec4> specular;
    /// Over the records on the pixel's own material: weight * recordMissed(), sum of weights; empty
    /// where no record missed anything.
    Image<vec4> missed;
};

/// Environment error where OpenGL's limits are too small for splatGpu() with these lobes: to be
/// known before anything is gathered.
void checkSplat(gl::WorkerPool& pool, const Receivers& receivers);

/// On the GPU: one quad a record, floating-point blending. checkSplat() must have passed. So many
/// pixels are drawn at a time, in whole rows: what OpenGL keeps does not grow beyond theirs, and
/// the sums do not depend on it.
SplatBuffer splatGpu(gl::WorkerPool& pool, const Receivers& receivers, const RecordCache& cache,
                     const WeightParams& weight, int band_pixels = kBandPixels);

/// The same on the CPU: for receivers that are no image, and what splatGpu() is tested against.
SplatBuffer splatCpu(const Receivers& receivers, const RecordCache& cache,
                     const WeightParams& weight);

/// Makes pixels whose rays glass has bent, which splatGpu() does not look for where they lie, what
/// splatCpu() makes of them.
void splatBent(const Receivers& receivers, const RecordCache& cache, const WeightParams& weight,
               SplatBuffer& splat);

/// What records say of the light above each receiver: [coefficient] of `order` bands, radiance in
/// world space; black where none serves it. All records must have as many bands.
std::vector<Image<vec3>> splatSh(const Receivers& receivers, const RecordCache& cache,
                                 const WeightParams& weight, int order);

/// What the scene's lightmaps, of which each receiver's surface has one unless it is unlit, say of
/// the irradiance, in place of records.
SplatBuffer splatLightmaps(const Scene& scene, const Receivers& receivers);

/// What the lobes of pixels that rays correct reflect by the records alone; black elsewhere.
Image<vec3> cachedSpecular(const Receivers& receivers, const SplatBuffer& splat);

/// How many records serve each pixel.
Image<float> countRecords(const Receivers& receivers, const RecordCache& cache,
                          const WeightParams& weight);

/// What compose() found in the images.
struct ComposeCounts {
    int nonfinite = 0;  ///< set to zero
    int negative = 0;   ///< pixels with a channel below zero, clamped

    void add(const ComposeCounts& other) {
        nonfinite += other.nonfinite;
        negative += other.negative;
    }
};

/// Divides by the weights, applies the reflectances and fills the frame's layers. `by_rays`: what
/// reflectSpecular() found; empty where no pixel is by rays. `geometry`: also fills the layers of
/// what the camera sees, 44 bytes a pixel.
ComposeCounts compose(const Receivers& receivers, const SplatBuffer& splat,
                      const Image<vec3>& by_rays, bool geometry, Frame& frame);

/// Receivers and what is known of the light that they reflect, as compose() takes it.
struct LitReceivers {
    const Receivers& receivers;
    const SplatBuffer& splat;
    const Image<vec3>& by_rays;
};

/// Makes pixels with edges, in the layers of light that compose() filled, what their samples see on
/// average.
ComposeCounts blendEdges(const Edges& edges, const LitReceivers& pixels, const LitReceivers& strays,
                         Frame& frame);

}  // namespace sheen
