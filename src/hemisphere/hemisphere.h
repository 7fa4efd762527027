// How a record sees its hemisphere: which rectangles are rasterised, and what each of their texels
// stands for. All directions are in the record's local frame, z along its normal.
// Based on: [GKB09, 8.4], [LC04], [CG85].
#pragma once

#include <cstdint>
#include <vector>

#include "core/math.h"

namespace sheen::shared {
using namespace glm;
#include "shared/hemisphere.glsl"
}  // namespace sheen::shared

namespace sheen {

/// How the hemisphere is covered: one plane whose border texels stretch to the horizon; the bare
/// plane, what it misses counted as black; the plane rescaled by its coverage [LC04]; or the five
/// faces of a hemicube [CG85].
enum class HemisphereKind { kBorder, kPlane, kLarsen, kHemicube };

struct HemisphereParams {
    HemisphereKind kind = HemisphereKind::kHemicube;
    int size = 38;        ///< texels along a side of the plane
    float extent = 3.0f;  ///< half-extent of the plane at distance 1; a hemicube's is always 1
};

/// A rasterised rectangle: texels [x, x+width) x [y, y+height) of the atlas show the directions
/// forward + u right + v up for u, v in [-1, 1].
struct HemisphereFace {
    vec3 right{};
    vec3 up{};
    vec3 forward{};
    int x = 0, y = 0, width = 0, height = 0;
};

/// A piece of a texel's footprint, for integrating anything over it.
struct FootprintSample {
    vec3 direction;
    float solid_angle;
};

/// The boundary between two texels a and b, from one corner of theirs to the next. When the record
/// moves by a vector t in its tangent plane, solid angle -dot(motion, t) / r passes from b to a,
/// where r is the distance of what the wall lies on; cosine_motion is the same with the cosine
/// integrated along the wall.
struct HemisphereWall {
    uint32_t a = 0;
    uint32_t b = 0;
    vec2 motion{};
    vec2 cosine_motion{};
    uint32_t corners[2] = {};
    /// Second derivatives xx, xy, yy of the cosine-weighted solid angle that passes from b to a,
    /// per product of the corners' inverse distances: of the first's square, of both, of the
    /// second's square.
    vec3 cosine_bend[3] = {};
};

struct Hemisphere {
    HemisphereParams params;
    int width = 0;  ///< of the atlas
    int height = 0;
    std::vector<HemisphereFace> faces;
    // Per texel of the atlas, row by row. Solid angles sum to 2 pi and cosines to pi for kBorder
    // and kHemicube; for kPlane both to what the plane covers; for kLarsen cosines to pi, and solid
    // angles, which are divided by the same share, to less than 2 pi.
    std::vector<vec3> directions;  ///< through the texel's centre
    std::vector<float> solid_angles;
    std::vector<float> cosines;       ///< integral of cos(theta)
    std::vector<vec2> moments;        ///< integral of the direction's tangential part
    std::vector<uint8_t> at_horizon;  ///< whether the footprint reaches the horizon
    std::vector<vec2> azimuths;       ///< of those: the azimuths where it does, first < second
    std::vector<HemisphereWall> walls;
    int corners = 0;  ///< of all walls

    int texelCount() const { return width * height; }
};

Hemisphere makeHemisphere(const HemisphereParams& params);

/// The footprint of one texel in pieces whose solid angles sum to its own; for kLarsen to what the
/// texel covers, which is less than what it counts for.
std::vector<FootprintSample> footprint(const Hemisphere& hemisphere, int texel);

}  // namespace sheen
