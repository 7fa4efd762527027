// Images to look at: exposed, tone-mapped (tonemap.h), 8-bit sRGB PNG.
#pragma once

#include <optional>
#include <string>

#include "image/frame.h"
#include "image/tonemap.h"

namespace sheen {

/// Writes `image` at `exposure` stops (none: by its log-average) to `path`, which appears whole or
/// not at all. Environment error where it cannot be written.
void writePng(const std::string& path, const Image<vec3>& image, std::optional<float> exposure);

/// The frame's beauty, see above; transparent where neither a surface nor a sky is seen.
void writePng(const std::string& path, const Frame& frame, std::optional<float> exposure,
              const ToDisplay& to_display = toSrgb());

/// Display values as they are, as the bytes of a PNG file; with a palette where 256 colours do.
std::string pngBytes(const Image<Rgb8>& image);

/// The same with how much each pixel covers, [0, 1].
std::string pngBytes(const Image<Rgb8>& image, const Image<float>& alpha);

/// Writes display values as they are: charts, false colours.
void writePng(const std::string& path, const Image<Rgb8>& image);

}  // namespace sheen
