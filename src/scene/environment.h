// The light of the surroundings: a sky infinitely far away, that every ray sees which meets no
// surface. Plain data and its lookup; whoever samples it does so by code of its own.
#pragma once

#include <string>
#include <vector>

#include "image/image.h"

namespace sheen {

struct Environment {
    /// Radiance, nits, by latitude and longitude: row 0 about +y, the middle column about -z, where
    /// cameras look unless turned, +x to its right. 1 x 1: the same from everywhere; empty: none.
    Image<vec3> texels;
    float rotation = 0.0f;  ///< about +y, radians, counter-clockwise seen from above
    bool visible = true;    ///< shows where the camera sees no surface; lights in any case

    bool empty() const { return texels.empty(); }
    bool shows() const { return visible && !empty(); }
    /// From a unit direction, that points away from the scene: bilinear between texel centres,
    /// around the seam; black where there is none.
    vec3 radiance(const vec3& direction) const;
    /// Where in the image that direction lies: [0, 1]^2, (0, 0) its first texel's corner.
    vec2 imageFromDirection(const vec3& direction) const;
    /// Its inverse.
    vec3 directionFromImage(const vec2& uv) const;
};

/// What the command line says of a scene's environment.
struct EnvironmentParams {
    std::string source;     ///< a file, "R,G,B" in nits, or "none"; empty: nothing is said
    float rotation = 0.0f;  ///< degrees, added
    float strength = 1.0f;  ///< factor of its radiance
    bool transparent = false;
    /// Whoever renders knows no sky: a scene without any light gets a key light and no studio.
    bool no_sky = false;
};

/// The environment of that name; empty for "none" and for nothing said. `files` gets the one that
/// is read, `warnings` a line for what was mended: texels that are negative or not finite are
/// black. Input error for a file that is missing, no image that is read (Radiance .hdr, OpenEXR),
/// damaged, or brighter than 1e12 nits; usage error for a colour of negative or too great numbers;
/// environment error where there is no memory for it.
Environment loadEnvironment(const EnvironmentParams& params, std::vector<std::string>& files,
                            std::vector<std::string>& warnings);

}  // namespace sheen
