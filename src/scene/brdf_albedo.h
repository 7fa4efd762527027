// Directional albedo of the specular lobe, split by Schlick's Fresnel: E_spec = F0 * A + F90 * B.
// The table is made when the project is built (make_brdf_albedo.cpp).
#pragma once

#include "core/math.h"

namespace sheen {

/// [roughness][mu][2]: (A, B) at shared::albedoTableParams(x, y).
const float* brdfAlbedoTable();

/// (A, B) at a view cosine and roughness, bilinear.
vec2 brdfAlbedo(float NoV, float roughness);

}  // namespace sheen
