// From scene-linear radiance to 8-bit sRGB.
//
// Curve by default: Khronos PBR Neutral, chosen because it shows colours as the material states
// them: it is the identity, less the 0.04 a white dielectric reflects, up to 0.76, and only above
// that compresses highlights and fades them to white at constant hue. Based on: [KhronosNeutral],
// Khronos Group, "PBR Neutral Tone Mapper", specification, 2024,
// github.com/KhronosGroup/ToneMapping; [Reinhard02], Reinhard, Stark, Shirley, Ferwerda,
// "Photographic Tone Reproduction for Digital Images", SIGGRAPH 2002, for the exposure.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>

#include "image/frame.h"

namespace sheen {

/// Exposure in stops that brings the log-average luminance of `image` to the middle grey 0.18
/// [Reinhard02, eq. 1-2; the paper's 1/N belongs inside the exponential]. Pixels that are black,
/// negative or not finite do not count; darker ones than a sixteenth of the others' mean count as
/// that. 0 where none is left. Scaling the image by 2^k lowers the result by k.
float autoExposure(const Image<vec3>& image);

enum class ToneCurve {
    kNeutral,  ///< [KhronosNeutral]
    kNone,     ///< what is brighter than white becomes white, channel by channel
};

/// Linear Rec. 709 radiance, exposed, to linear Rec. 709 in [0, 1]. Negative components count as 0.
vec3 toneMap(const vec3& color, ToneCurve curve = ToneCurve::kNeutral);

/// The sRGB transfer function (IEC 61966-2-1), [0, 1] to [0, 1].
float srgbFromLinear(float linear);

struct Rgb8 {
    uint8_t r = 0, g = 0, b = 0;
};

/// Display values in [0, 1] (clamped), already sRGB-encoded, rounded to nearest.
Image<Rgb8> bytesFromDisplay(const Image<vec3>& image);

/// From exposed linear Rec. 709 radiance to what a display is sent, [0, 1] where it shows it.
using ToDisplay = std::function<vec3(const vec3&)>;

/// Through the curve and the sRGB transfer function.
ToDisplay toSrgb(ToneCurve curve = ToneCurve::kNeutral);

/// 2^exposure * image as a display is sent it, rounded to nearest. Pixels that are not finite
/// become magenta, so that they are seen. `exposure` in stops; none: autoExposure.
Image<Rgb8> displayImage(const Image<vec3>& image, std::optional<float> exposure,
                         const ToDisplay& to_display = toSrgb());

}  // namespace sheen
