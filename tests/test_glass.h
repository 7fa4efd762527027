// Glass of small scenes.
#pragma once

#include "test_scenes.h"

namespace sheen {

/// A sheet of glass, of index 1.5.
inline uint32_t addGlass(Scene& scene, const vec3& color, float roughness = 0.0f) {
    MaterialParams params = glossyParams(color, 0.0f, roughness);
    params.transmission = 1.0f;
    const uint32_t material = addMaterial(scene, params);
    scene.materials[material].blended = true;
    return material;
}

/// A body of glass. What it reflects is that of its index at normal incidence.
inline uint32_t addBody(Scene& scene, float ior, float roughness = 0.0f,
                        const vec3& color = vec3(1.0f)) {
    const uint32_t material = addGlass(scene, color, roughness);
    const float root = (ior - 1.0f) / (ior + 1.0f);
    scene.materials[material].params.specular_color = vec3(root * root / 0.04f);
    scene.materials[material].ior = ior;
    return material;
}

}  // namespace sheen
