// Where a camera's ray goes that looks through glass: bent by Snell's law where it enters or leaves
// a body, and spread by what is rough. Other rays pass straight. Based on: the glTF extensions
// KHR_materials_volume and KHR_materials_transmission, [WMLT07].
#pragma once

#include <optional>

#include "rays/surface_point.h"

namespace sheen {

/// How a ray goes on that passes a surface.
struct Passage {
    vec3 direction;          ///< unit
    vec3 outside;            ///< unit: of the ray where it is not in the body, or on its way there
    bool bent = false;       ///< it starts anew, from startOf()
    bool reflected = false;  ///< totally: it stays in the body
    float leaving = 0.0f;    ///< of a body: the cosine outside; 0: it does not

    vec3 startOf(const Scene& scene, const SurfacePoint& p) const;
};

/// Whether passageAt() may do more than let rays pass. `rough`: where roughness counts.
inline bool bendsRays(const Material& material, bool rough) {
    return material.refracts() || (rough && material.blurs());
}

/// Of a ray that comes along -p.wo, from within the body where it meets the surface's `back`. Each
/// body has air around it. By the mapped normal or, given a place in the lobe, by a microfacet's,
/// chosen by how much of each the ray sees [Hei18]; a rough sheet spreads what passes as what it
/// reflects. None goes to the side of the surface that it should not reach: what would is mirrored.
Passage passageAt(const Scene& scene, const SurfacePoint& p, bool back,
                  const std::optional<vec2>& lobe);

}  // namespace sheen
