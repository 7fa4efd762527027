// Paths from the points that pixels see into the scene: the reference's integrand.
// Based on: [Kaj86], [VG95].
#pragma once

#include "reference/guide.h"
#include "reference/light.h"
#include "reference/reference.h"

namespace sheen {

/// Of the sequences by which lamps are chosen.
constexpr uint32_t kLampSeed = 0x6c616d70u;

/// Where a path starts: the point it leaves and how it leaves it.
struct Start {
    Surface p;
    BrdfSampler sampler;

    explicit Start(const Surface& surface)
        : p(surface),
          sampler(surface.brdf, surface.specular_albedo, surface.n, surface.wo, surface.coat) {}
};

struct PathContext {
    const RayScene& rays;
    const Lights& lights;
    const ReferenceParams& params;
    int samples_per_replicate;
    int guide_size;  ///< cells along a side; 0: no guide
    /// Of the image that the frame may be a part of: a place there is the same digits.
    Camera whole_camera;
    ivec2 whole_size;
};

/// What a path brings that leaves its start toward the camera.
struct PathSample {
    Scattered indirect;
    vec3 caustic{0.0f};  ///< apart from that, if it is wanted so

    bool isFinite() const {
        return finite(indirect.all) && finite(indirect.diffuse) && finite(caustic);
    }
};

/// One sample, by point `index` of the sequences of `seed`, of the indirect light that arrives in
/// directions chosen by the BRDF.
PathSample samplePath(const PathContext& context, const Start& start, const Guide& guide,
                      uint32_t index, uint32_t seed, Counters& counters);

/// And of what of the sky's light the other half of the estimate brings: by directions toward it.
/// (Weights of both halves are those of plain BRDF samples: they add up to one whatever the guide.)
Scattered sampleSkyFromStart(const PathContext& context, const Start& start, uint32_t index,
                             uint32_t seed, Counters& counters);

}  // namespace sheen
