// What a record adds to a pixel's irradiance, and to what lobes see beside that where MISSED is 1, on
// bumps of normal maps where BUMPS is;
// blending sums it over the records.
#include "splat/fragment.glsl"

#if BUMPS == 1
layout(binding = 4, rgba32f) readonly uniform image2D bumps;  // normals by normal maps
#endif
layout(location = 0) out vec4 out_irradiance;  // weight * irradiance, weight
#if MISSED == 1
layout(binding = 3, r32i) readonly uniform iimage2D materials;
layout(location = 1) out vec4 out_missed;  // of records on the same material: weight * missed, weight
#endif

void main() {
    Pixel pixel = weighPixel();
    if (pixel.weight <= 0.0) {
        discard;
    }
    Record k;  // its values are the quad's, but for integers and padding
    k.position = values[0].xyz;
    k.normal = values[1].xyz;
    k.irradiance = values[3].xyz;
    k.rotation_r = values[4].xyz;
    k.rotation_g = values[5].xyz;
    k.rotation_b = values[6].xyz;
    k.translation_r = values[7].xyz;
    k.translation_g = values[8].xyz;
    k.translation_b = values[9].xyz;
#if BUMPS == 1
    vec3 bump = imageLoad(bumps, ivec2(gl_FragCoord.xy)).xyz;
    vec3 irradiance = bumpIrradiance(k, pixel.position, pixel.normal, bump);
#else
    vec3 irradiance = recordIrradiance(k, pixel.position, pixel.normal);
#endif
    out_irradiance = vec4(pixel.weight * irradiance, pixel.weight);
#if MISSED == 1
    float same = imageLoad(materials, ivec2(gl_FragCoord.xy)).x == int(values[3].w) ? 1.0 : 0.0;
    out_missed = same * pixel.weight * vec4(values[4].w, values[5].w, values[6].w, 1.0);
#endif
}
