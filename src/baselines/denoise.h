// The path tracer's image, smoothed: an edge-avoiding a-trous wavelet filter over light divided by
// albedo, guided by geometry and by the image's own variance.
// Based on: [DSHL10], with the luminance weight of [SKWKLBHL17], without its reuse over time.
#pragma once

#include "reference/reference.h"

namespace sheen {

/// How a layer is filtered. A neighbour's weight is exp(-u), u the sum of what follows, each in
/// units of the scale given here.
struct AtrousParams {
    int levels = 4;           ///< the taps of level i are 2^i pixels apart
    float luminance = 3.0f;   ///< difference of luminance, of the two standard deviations' sum
    float normal = 0.06f;     ///< 1 - cosine between the normals
    float plane = 0.25f;      ///< sine of the angle between a tangent plane and the way to another
    float roughness = 0.05f;  ///< difference of roughness
};

/// `color` divided by `albedo`, filtered, and multiplied again, channel by channel; where the
/// albedo is black, as it was. Pixels that see nothing are left alone and lend nothing; pixels
/// without variance whose neighbours have none either keep their value unless it is equal to
/// theirs. `variance` is of the mean, per channel; `guide` gives position, normal, roughness and
/// primitive.
Image<vec3> filterAtrous(const Image<vec3>& color, const Image<vec3>& variance,
                         const Image<vec3>& albedo, const Frame& guide,
                         const AtrousParams& params = {});

/// Filters the indirect light of a path-traced frame, diffuse and specular part on their own.
/// Emission stays, and so does direct light: the noise of lamps is so low there that the filter's
/// blur of shadows would be worse. The variances, which do not know of what the filter blurred, are
/// taken out of the frame.
void denoise(ReferenceResult& traced);

}  // namespace sheen
