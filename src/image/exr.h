// Frames as OpenEXR files: the lossless output of a render and the input of a comparison.
//
// Layers and their channels; depth, normals and positions by the names that compositors expect:
//   beauty R,G,B,A          direct + indirect + caustic + emission; A is 1 where geometry or a sky
//                           is seen, else 0
//   direct, indirect, caustic, indirect_diffuse, emission, albedo    .R .G .B
//   N (normal), P (position)    .X .Y .Z
//   Z (depth), roughness.Y weight.Y records.Y
//   CryptoMaterial00.R .G .B .A, ...01, CryptoObject00, ...    see cryptomatte.h
//   primitive.id            unsigned integer, kNoPrimitive where nothing is seen
//   variance, variance_diffuse, variance_direct, variance_caustic, variance_global    .R .G .B;
//                           variance of the mean of indirect, indirect_diffuse, direct, caustic,
//                           and indirect + caustic
// Colours, normals and roughness are half, everything else is float. A frame that carries variances
// (the reference) keeps its colours in float as well, so that judging by it is exact.
#pragma once

#include <map>
#include <span>
#include <string>

#include "image/cryptomatte.h"
#include "image/frame.h"

namespace sheen {

enum class ExrLayers {
    kBasic,  ///< beauty, direct, indirect, caustic, primitive, variances and the layers they belong
             ///< to
    kAll,    ///< every layer the frame has
};

/// What a file says of itself: attributes of its header, by their names.
struct ExrNotes {
    std::map<std::string, std::string> texts;
    std::map<std::string, float> numbers;
};

/// A layer of colours that no frame has.
struct ExrColors {
    std::string name;
    const Image<vec3>* colors = nullptr;
};

/// Writes such layers, and the channels of numbers of those names, all of one size, in floats.
/// Errors as writeExr().
void writeExrLayers(const std::string& path, std::span<const ExrColors> colors,
                    const std::map<std::string, Image<float>>& numbers, const ExrNotes& notes = {});

/// Writes `frame`, `mattes` of it and `more` layers, in floats, to `path`, which appears whole or
/// not at all. Environment
/// error where the file cannot be written.
void writeExr(const std::string& path, const Frame& frame, ExrLayers layers,
              const ExrNotes& notes = {}, std::span<const Matte> mattes = {},
              std::span<const ExrColors> more = {});

/// What an EXR file holds. Half and integer channels are converted to float.
struct LoadedExr {
    std::string path;
    int width = 0;
    int height = 0;
    std::map<std::string, Image<vec3>> colors;    ///< .R .G .B or .X .Y .Z; unnamed layer: "beauty"
    std::map<std::string, Image<float>> scalars;  ///< every other channel, by its full name
    Image<uint32_t> primitive;                    ///< empty where the file has none
};

/// Reads any flat EXR file of one part. Input error, naming the path: missing, a folder, not an
/// EXR file, damaged or incomplete, larger than 16384 a side, subsampled channels.
LoadedExr readExr(const std::string& path);

/// Layer `name` of a file. Input error, listing what the file has, where it is missing.
const Image<vec3>& colorLayer(const LoadedExr& exr, const std::string& name);

}  // namespace sheen
