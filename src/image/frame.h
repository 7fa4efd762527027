// A rendered frame: what `sheen render` writes, whatever the method. Layers that a render does not
// make are empty images.
#pragma once

#include <cstdint>
#include <vector>

#include "image/image.h"

namespace sheen {

/// `primitive` of a pixel that sees no geometry.
constexpr uint32_t kNoPrimitive = 0xffffffffu;

/// A triangle that is seen in a part of a pixel.
struct Fragment {
    uint32_t pixel = 0;
    uint32_t primitive = 0;
    float coverage = 0;  ///< of the pixel
};

struct Frame {
    // Outgoing radiance toward the camera, glTF's photometric scale (nits).
    Image<vec3> direct;            ///< punctual lights and lamps, one scattering
    Image<vec3> indirect;          ///< design section 3; diffuse and specular
    Image<vec3> indirect_diffuse;  ///< its diffuse part
    Image<vec3> caustic;     ///< of lights, by specular surfaces alone; empty: part of indirect
    Image<vec3> emission;    ///< of what is seen; where that is nothing, the sky or black
    bool shows_sky = false;  ///< pixels that see nothing are not transparent
    Image<float> coverage;  ///< share of a pixel that sees a surface; empty: all or nothing, as its
                            ///< middle does
    // The G-buffer.
    Image<vec3> albedo;         ///< diffuse reflectance toward the camera, 0..1
    Image<vec3> normal;         ///< shading normal, world space, on the camera's side
    Image<vec3> position;       ///< of a rendered frame, in the coordinates of the scene's file
    Image<float> roughness;     ///< perceptual (glTF)
    Image<float> depth;         ///< along the view axis, scene units; +inf where nothing is seen
    Image<uint32_t> primitive;  ///< triangle index in Scene, or kNoPrimitive
    /// Of pixels that an edge passes through, all that is seen in them, by pixel; others see their
    /// `primitive` alone.
    std::vector<Fragment> fragments;
    // The cache.
    Image<float> weight;   ///< sum of record weights
    Image<float> records;  ///< number of records serving the pixel
    /// Root of the squared error of the indirect light's luminance that its records expect of each
    /// other; the same for 2 x 2 pixels.
    Image<float> error;
    // The reference: variance of the mean, from independent replicates.
    Image<vec3> indirect_variance;
    Image<vec3> indirect_diffuse_variance;
    Image<vec3> direct_variance;
    Image<vec3> caustic_variance;
    Image<vec3> global_variance;  ///< of indirect and caustic together

    int width() const { return primitive.width; }
    int height() const { return primitive.height; }
};

/// How much of a pixel is covered: the share that sees a surface or a sky that shows.
Image<float> alpha(const Frame& frame);

/// What the camera sees: direct + indirect + caustic + emission; a layer the frame lacks counts as
/// black.
Image<vec3> beauty(const Frame& frame);

/// A layer that a frame has, of one kind of pixels.
struct FrameLayer {
    /// What its values are, and so what its channels are called: R, G, B; X, Y, Z; Y; or, of a
    /// depth, Z without a layer.
    enum class Kind { kColor, kVector, kNumber, kDepth };
    const char* name;
    const char* in_files;  ///< as other programs call it: docs/conventions.md
    Kind kind;
    bool exact;  ///< halves would not do
    bool basic;  ///< of every file, not only where all layers are asked for
    const Image<vec3>* triples = nullptr;
    const Image<float>* numbers = nullptr;
};

/// All that are not empty, but for beauty, alpha and primitive, which each frame has.
std::vector<FrameLayer> layersOf(const Frame& frame);

}  // namespace sheen
