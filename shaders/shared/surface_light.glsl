// Where a triangle keeps the light it scatters: a square of 2^log2_size texels to a side over its
// barycentric coordinates (the half beyond the hypotenuse stays unused), followed by its mip levels.
#ifndef SHARED_SURFACE_LIGHT_GLSL
#define SHARED_SURFACE_LIGHT_GLSL

#include "shared/language.glsl"

// A triangle as the gather reads it.
struct LitTriangle {
    vec3 p0;
    uint first;      // texel of level 0
    vec3 p1;
    int log2_size;
    vec3 p2;
    int lambertian;  // 1: the stored light is all it scatters; 0: shaded where it is hit
};

// Texels before a level's first: sizes are 4^log2_size, 4^(log2_size - 1), ...
FN uint surfaceLightLevelFirst(int log2_size, int level) {
    uint all = (4u << uint(2 * log2_size)) - 1u;
    uint rest = (4u << uint(2 * (log2_size - level))) - 1u;
    return (all - rest) / 3u;
}

// Texel of barycentrics (b1, b2) in a level.
FN uint surfaceLightTexel(int log2_size, int level, float b1, float b2) {
    int size = 1 << (log2_size - level);
    int i = clamp(int(b1 * float(size)), 0, size - 1);
    int j = clamp(int(b2 * float(size)), 0, size - 1);
    return surfaceLightLevelFirst(log2_size, level) + uint(j * size + i);
}

#endif
