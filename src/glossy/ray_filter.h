// What pixels saw by a few rays each, without the noise: a regression on what the records say, in
// windows as wide as the noise asks for and the light allows.
// Based on: [RMZ13], [BRM16].
#pragma once

#include "image/image.h"
#include "receivers/receivers.h"

namespace sheen {

/// The light of pixels' lobes by two halves of their rays, independent of each other.
struct NoisyLight {
    Image<vec3> halves[2];
    /// What is known of it without noise: as far as both vary alike in a window, the light follows
    /// this instead of the mean. The same everywhere: nothing is known.
    Image<vec3> guide;
    Image<float> nearness;  ///< mean of one over the distance that a pixel's light comes from
};

/// The light of the pixels in Receivers::by_rays; black elsewhere. In windows of several widths
/// around a pixel, the light is fitted by a plane in the image plus a multiple of the guide; the
/// width is the one at which either half of the rays is best told by the fit to the other. Pixels
/// of another material or class, or a step away, take no part.
Image<vec3> filterLight(const Receivers& receivers, const NoisyLight& light);

}  // namespace sheen
