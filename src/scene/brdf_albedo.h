// Directional albedo of the specular lobe, split by Schlick's Fresnel: E_spec = F0 * A + F90 * B.
// The table is made when the project is built (make_brdf_albedo.cpp).
#pragma once

#include "core/math.h"

namespace sheen {

/// [roughness][mu][2]: (A, B) at shared::albedoTableParams(x, y).
const float* brdfAlbedoTable();

/// (A, B) at a view cosine and roughness, bilinear.
vec2 brdfAlbedo(float NoV, float roughness);

/// What a specular lobe reflects of constant light, seen at that cosine.
inline vec3 specularAlbedo(float NoV, float roughness, const vec3& f0, float f90) {
    const vec2 ab = brdfAlbedo(NoV, roughness);
    return f0 * ab.x + vec3(f90 * ab.y);
}

}  // namespace sheen
