// Specular light of pixels whose lobes spherical harmonics do not follow: rays of their own correct
// what their records say or, where they are too glossy for the cache, say all of it. Noise is
// filtered.
#pragma once

#include "image/image.h"
#include "light/outgoing.h"
#include "receivers/receivers.h"

namespace sheen {

/// Defaults were chosen by measurement (docs/decisions/glossy.md).
struct SpecularParams {
    float rays_per_alpha = 7680;  ///< a pixel's rays by its lobe's width, in whole packets
    int max_rays = 768;           ///< a pixel
    /// Of pixels too glossy for the cache rays leave from all that they see of the middle's
    /// surface, not from the middle alone. Receivers are then the pixels of an image.
    bool pixel_area = false;
    float window = 2;  ///< typical deviation of the windows that share corrected pixels'
                       ///< rays, in pixels: rays see highlights as wide as all of them do
};

/// What the lobe of a pixel sees by two halves of its rays, over the lobe's albedo.
struct SpecularSeen {
    vec3 light[2] = {};   ///< mean of the rays' weights times what they see
    vec3 weight[2] = {};  ///< mean of the weights: about one
    float nearness = 0;   ///< mean of one over the distance it comes from; 0: no ray met anything
};

/// What the lobes of Receivers::by_rays see of indirect light. Rays follow the lobe (visible
/// normals [Hei18]) at random places; they see the light that records see.
Image<SpecularSeen> traceSpecular(const OutgoingLight& light, const Receivers& receivers,
                                  const SpecularParams& params);

/// The mean of the light that a pixel's lobe sees by `share` times as many rays as usual, others
/// than before for each `sample` from 0 on.
vec3 seeAgain(const OutgoingLight& light, const Receivers& receivers, size_t pixel, float share,
              int sample, const SpecularParams& params);

/// What these lobes reflect; black elsewhere. `cached`: by the records alone, as cachedSpecular()
/// finds it; of pixels too glossy for the cache it is not asked. `neighbours`: the receivers are
/// an image's pixels, of which those around tell what of a lobe's light is noise; else it stays.
Image<vec3> reflectSpecular(const Receivers& receivers, const Image<SpecularSeen>& seen,
                            const Image<vec3>& cached, bool neighbours = true);

}  // namespace sheen
