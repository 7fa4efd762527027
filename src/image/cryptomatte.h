// Which material or object each pixel shows, by how much: Cryptomatte, version 1.2, which
// compositors take masks from by name.
#pragma once

#include <string>
#include <vector>

#include "image/frame.h"

namespace sheen {

/// What triangles belong to.
struct MatteNames {
    std::string layer;               ///< "CryptoMaterial"
    std::vector<std::string> names;  ///< each once
    std::vector<uint32_t> of;        ///< [primitive] index in `names`
};

/// Channels of an EXR file, and its header's attributes.
struct Matte {
    std::string layer;
    std::string manifest;  ///< JSON, from a name to its identifier in hexadecimal digits
    /// Two names a pixel each, those that cover more first: identifier, coverage, identifier,
    /// coverage. Zeros where a pixel shows no more.
    std::vector<Image<vec4>> ranks;
};

/// The six names at the most that cover most of each pixel, as the frame's fragments and primitives
/// tell.
Matte makeMatte(const Frame& frame, const MatteNames& names);

/// A name's identifier: its MurmurHash3 of 32 bits, seed 0, as a float that is finite and normal.
float matteIdentifier(const std::string& name);

}  // namespace sheen
