// Where on surfaces light is to be kept: on what is seen from where light is looked for, and on
// what is seen from there.
#pragma once

#include <span>

#include "light/elements.h"
#include "rays/tracer.h"

namespace sheen {

/// Spread so that they lie closer together where they are seen from nearby, and where surfaces
/// nearby make light vary; not more than there should be at the most, so that some points may have
/// none near. `from`: points of surfaces from which light is going to be looked for, spread over
/// all of them; their spacing is not asked.
Elements placeElements(const Tracer& tracer, std::span<const ElementSite> from);

/// Directions from a site, rows x columns strata of equal cosine but for those that lead below the
/// surface, and what of the solid angle each stands for.
struct Looks {
    std::vector<vec3> directions;
    std::vector<float> solid_angles;

    Looks(const ElementSite& site, int rows, int columns, uint32_t seed);
};

/// The site of what a ray of direction -wo met or, at Embree's barycentric uv, of another point of
/// the same side of the same triangle.
ElementSite elementSiteAt(const Scene& scene, const Hit& hit, const vec2& uv, const vec3& wo);

}  // namespace sheen
