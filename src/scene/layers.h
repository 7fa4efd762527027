// What lies on a surface and scatters light before it does: fibres (KHR_materials_sheen), and on
// top a clear coat (KHR_materials_clearcoat).
#pragma once

#include "core/math.h"
#include "scene/shared.h"

namespace sheen {

/// Of one point.
struct Layers {
    float coat = 0.0f;            ///< how much of the surface is coated
    float coat_roughness = 0.0f;  ///< perceptual
    vec3 fibre_color{0.0f};
    float fibre_roughness = 0.0f;

    bool none() const { return coat == 0.0f && fibre_color == vec3(0.0f); }
};

/// The coat as a surface of its own that scatters nothing diffusely: of index 1.5.
shared::Brdf coatBrdf(const Layers& layers);

/// What the coat reflects of constant light toward a viewer at that cosine.
float coatAlbedo(const Layers& layers, float NoV);

/// What white fibres reflect of constant light: the microfacet distribution "Charlie" with
/// V = 1 / (4 (NoL + NoV - NoL NoV)). [EK17, eq. 2]
float fibreAlbedo(float NoV, float roughness);

/// What share of the light toward the viewer its layers leave to the surface. `NoV_coat`: the coat
/// has normals of its own.
float shareUnderLayers(const Layers& layers, float NoV, float NoV_coat);

/// The surface below: what its layers reflect toward the viewer it does not get. What fibres
/// reflect leaves as diffuse light of the same albedo; the coat's is not in it.
shared::Brdf underLayers(const shared::Brdf& surface, const Layers& layers, float NoV,
                         float NoV_coat);

}  // namespace sheen
