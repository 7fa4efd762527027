// From the visibility buffer to everything the later stages read of a pixel.
#include "raster/direct.glsl"

layout(std430, binding = 0) readonly buffer Views { View views[]; };
layout(binding = 1) uniform usampler2D visibility;
uniform vec2 image_size;

layout(location = 0) out vec4 out_position;  // world space; w: depth along the view axis, 0: none
layout(location = 1) out vec4 out_normal;    // shading normal; w: perceptual roughness
layout(location = 2) out vec4 out_diffuse;   // diffuse reflectance; w: F90
layout(location = 3) out vec4 out_f0;        // F0; w: scene triangle, see triangleBits
layout(location = 4) out vec4 out_direct;    // direct radiance
layout(location = 5) out vec4 out_emission;

// An index as the bits of a normal number: as a small integer it would be a denormal, which may be
// flushed to zero on the way.
float triangleBits(uint index) {
    return uintBitsToFloat(index | 0x40000000u);
}

void main() {
    uint id = texelFetch(visibility, ivec2(gl_FragCoord.xy), 0).x;
    out_position = vec4(0.0);
    out_normal = vec4(0.0);
    out_diffuse = vec4(0.0);
    out_f0 = vec4(0.0);
    out_direct = vec4(0.0);
    out_emission = vec4(0.0);
    if (id == 0u) {
        return;
    }
    View view = views[0];
    vec2 uv = gl_FragCoord.xy / image_size * 2.0 - 1.0;
    vec3 direction = normalize(viewDirection(view, uv));
    Surface s = surfaceAt(id - 1u, view.origin, direction, 0.0);
    vec3 wo = normalize(view.origin - s.p);
    float NoV = max(dot(s.n, wo), MIN_COSINE);
    Brdf brdf = makeBrdf(s.material, brdfAlbedo(NoV, s.material.roughness));
    out_position = vec4(s.p, dot(view.dual_forward, s.p - view.origin));
    out_normal = vec4(s.n, s.material.roughness);
    out_diffuse = vec4(brdf.diffuse, brdf.f90);
    out_f0 = vec4(brdf.f0, triangleBits(s.scene_triangle));
    out_direct = vec4(directRadiance(s, wo, 0.0), 0.0);
    out_emission = vec4(s.material.emission, 0.0);
}
