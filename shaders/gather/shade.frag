// Radiance that each texel of a batch of hemispheres receives from surfaces that are not Lambertian,
// shaded where they are hit: direct light scattered once toward the record, and emission.
#include "raster/direct.glsl"
#include "shared/surface_light.glsl"
#include "gather/texel.glsl"

layout(std430, binding = 7) readonly buffer LitTriangles { LitTriangle lit_triangles[]; };

layout(location = 0) out vec4 out_radiance;  // w: distance

void main() {
    uint id = visibleTriangle();
    if (id == 0u || lit_triangles[id - 1u].lambertian != 0) {
        discard;
    }
    GatherTexel texel = gatherTexel();
    Surface s = surfaceAt(id - 1u, texel.origin, texel.direction, texel.solid_angle);
    vec3 wo = normalize(texel.origin - s.p);
    out_radiance = vec4(directRadiance(s, wo, texel.solid_angle) + s.material.emission, s.distance);
}
