// Where light is to be gathered.
#pragma once

#include <cstdint>
#include <vector>

#include "receivers/receivers.h"

namespace sheen {

/// Where the light that a record sees changes within a texel. `strength`: by how much, twice its
/// standard deviation there, in units of what a texel brings on average; as a hemisphere of the
/// usual size would see it.
struct Contrast {
    vec3 position{};
    float strength = 0;
};

/// The specular lobe of a surface seen from somewhere; f90 and f0 are 0 where there is none.
struct SpecularLobe {
    float alpha = 1;
    float f0 = 0;  ///< mean of the channels
    float f90 = 0;

    bool any() const { return f0 > 0.0f || f90 > 0.0f; }
};

/// A point where light is to be gathered.
struct RecordSite {
    vec3 position{};
    vec3 normal{};            ///< shading normal: the hemisphere's pole
    vec3 geometric_normal{};  ///< on the same side
    vec3 toward_viewer{};     ///< unit, to whoever sees the site; zero where no one does
    float offset = 0;         ///< surfaceOffset()
    /// Of its random numbers. From its place on the surface, never from what was gathered before:
    /// noise then stays where it is when the camera moves.
    uint32_t seed = 0;
    int order = shared::DIFFUSE_ORDER;
    SpecularLobe lobe = {};  ///< toward the viewer, where what it sees is wanted
    float reach = 0;         ///< that its record will most likely have, in pixels; 0: not known
    std::vector<Contrast> contrasts = {};  ///< what records nearby found: where to look closer
    bool first = false;                    ///< of the first grid: few have records nearby
    uint32_t triangle = ~0u;               ///< that it lies on; ~0: not known

    /// From where the site is looked out of.
    vec3 eye() const { return offSurface(position, geometric_normal, toward_viewer, offset); }
};

/// Where a receiver's light is to be gathered; of the records around it nothing is known yet. On
/// the smooth surface, of whose bumps no lobe is known, or, `on_bump`, about the normal by which it
/// scatters.
RecordSite siteAt(const Scene& scene, const Receivers& receivers, size_t i, bool on_bump = false);

}  // namespace sheen
