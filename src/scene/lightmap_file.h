// A scene's file with lightmaps in it: what it held before, each mesh with the coordinates of its
// triangles in the atlas.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "scene/scene.h"

namespace sheen {

struct LightmapFile {
    std::string source;                        ///< the file that the scene was loaded from
    std::vector<std::array<vec2, 3>> corners;  ///< [triangle], in the unit square from the top left
    std::vector<int> page_of;                  ///< [triangle]: its image
    bool of_file = false;           ///< these are the file's own second texture coordinates
    std::vector<std::string> pngs;  ///< images' bytes
    /// What the images are: linear irradiance, of which 1 stands for `intensity` (MOZ_lightmap), or
    /// colours that are shown as they are, instead of all that materials had (unlit).
    bool unlit = false;
    float intensity = 1.0f;
    /// Whether what lights and lamps send is in the image, so that the file has to do without
    /// punctual ones.
    bool lights_baked = false;
};

/// Throws the input errors of writeLightmapped(), before there is an image.
void checkLightmapped(const Scene& scene, const LightmapFile& lightmap);

/// Writes a .glb file, which appears whole or not at all. `scene` was loaded by
/// LoadParams::sources. Image-based light of the file is left out where the scene has a sky, which
/// is in the lightmap. Input error where something cannot be taken over: instances, which have no
/// coordinates of their own, parts that are not there or malformed, more than 4 GiB. Environment
/// error where the file cannot be written.
void writeLightmapped(const std::string& path, const Scene& scene, const LightmapFile& lightmap);

}  // namespace sheen
