// Radiance .hdr files (RGBE): images of light that others made, such as a sky.
#pragma once

#include <string>

#include "image/image.h"

namespace sheen {

/// Reads a Radiance file; linear RGB in its own scale, row 0 on top. Input error, naming the path:
/// missing, a folder, no Radiance file, damaged or cut short, larger than 16384 a side; environment
/// error where there is no memory for it.
Image<vec3> readHdr(const std::string& path);

}  // namespace sheen
