// The scene as the shaders see it: from a triangle index and a ray to the surface that was hit.
// Positions come from the ray and the triangle, not from a depth buffer, so that they are as exact
// as single precision allows.
#include "shared/brdf.glsl"
#include "shared/light.glsl"

struct PackedTriangle {
    vec3 p0; uint material;
    vec3 p1; float uv0_x;
    vec3 p2; float uv0_y;
    vec3 n0; float uv1_x;
    vec3 n1; float uv1_y;
    vec3 n2; float uv2_x;
    float uv2_y; uint pad1; float lod_error; float pad0;
};
struct PackedMaterial {
    MaterialParams params;
    int texture_first;   // texel index of level 0, -1: no texture
    int texture_levels;
    int texture_width;
    int texture_height;
    ivec2 texture_wrap;
    int pad0;
    int pad1;
};
layout(std430, binding = 1) readonly buffer Triangles { PackedTriangle triangles[]; };
layout(std430, binding = 2) readonly buffer Materials { PackedMaterial materials[]; };
layout(std430, binding = 3) readonly buffer Texels { uvec2 texels[]; };
layout(std430, binding = 4) readonly buffer Lights { PunctualLight lights[]; };
layout(std430, binding = 5) readonly buffer AlbedoTable { vec2 albedo_table[]; };
uniform int light_count;

struct Surface {
    vec3 p;          // world space
    float distance;  // from the ray's origin
    vec3 n_g;        // geometric normal, facing the viewer
    vec3 n;          // shading normal
    MaterialParams material;
    float lod_error; // how far the true surface may lie from p
};

vec3 texelColor(int index) {
    uvec2 halves = texels[index];
    return vec3(unpackHalf2x16(halves.x), unpackHalf2x16(halves.y).x);
}

vec3 textureColor(PackedMaterial m, vec2 uv, float level) {
    int first = m.texture_first;
    ivec2 size = ivec2(m.texture_width, m.texture_height);
    int steps = int(clamp(level + 0.5, 0.0, float(m.texture_levels - 1)));
    for (int i = 0; i < steps; ++i) {
        first += size.x * size.y;
        size = max(size / 2, ivec2(1));
    }
    TextureTaps t = textureTaps(uv, size, m.texture_wrap);
    vec3 lower = mix(texelColor(first + t.lower.y * size.x + t.lower.x),
                     texelColor(first + t.lower.y * size.x + t.upper.x), t.fraction.x);
    vec3 upper = mix(texelColor(first + t.upper.y * size.x + t.lower.x),
                     texelColor(first + t.upper.y * size.x + t.upper.x), t.fraction.x);
    return mix(lower, upper, t.fraction.y);
}

// The point where a ray from `origin` meets a triangle that the rasteriser said it meets: clamped
// to the triangle, since the two may disagree in the last bit. `texel_solid_angle` selects the
// texture level; 0 reads the finest.
Surface surfaceAt(uint triangle, vec3 origin, vec3 direction, float texel_solid_angle) {
    PackedTriangle t = triangles[triangle];
    vec3 e1 = t.p1 - t.p0;
    vec3 e2 = t.p2 - t.p0;
    vec3 to_origin = origin - t.p0;
    // Moeller-Trumbore
    vec3 s = cross(direction, e2);
    float det = dot(e1, s);
    vec3 q = cross(to_origin, e1);
    float inverse_det = det == 0.0 ? 0.0 : 1.0 / det;
    float b1 = clamp(dot(to_origin, s) * inverse_det, 0.0, 1.0);
    float b2 = clamp(dot(direction, q) * inverse_det, 0.0, 1.0 - b1);
    float b0 = 1.0 - b1 - b2;

    Surface surface;
    surface.p = t.p0 + b1 * e1 + b2 * e2;
    vec3 wo = origin - surface.p;
    surface.distance = length(wo);
    wo /= max(surface.distance, 1e-30);
    vec3 scaled_normal = cross(e1, e2);  // its length is twice the area
    float area2 = length(scaled_normal);
    surface.n_g = faceViewer(scaled_normal / area2, wo);
    vec3 n = interpolatedNormal(b0 * t.n0 + b1 * t.n1 + b2 * t.n2, surface.n_g);
    surface.n = shadingNormal(n, surface.n_g, wo);
    surface.lod_error = t.lod_error;
    PackedMaterial m = materials[t.material];
    surface.material = m.params;
#ifdef TEXTURED
    if (m.texture_first >= 0) {
        vec2 uv0 = vec2(t.uv0_x, t.uv0_y);
        vec2 uv1 = vec2(t.uv1_x, t.uv1_y);
        vec2 uv2 = vec2(t.uv2_x, t.uv2_y);
        float level = 0.0;
        if (texel_solid_angle > 0.0) {
            vec2 d1 = uv1 - uv0;
            vec2 d2 = uv2 - uv0;
            float uv_area2 = abs(d1.x * d2.y - d1.y * d2.x);
            float footprint = texel_solid_angle * surface.distance * surface.distance /
                              max(abs(dot(surface.n_g, wo)), 0.05);
            float texels_seen = footprint * uv_area2 / area2 *
                                float(m.texture_width * m.texture_height);
            level = 0.5 * log2(max(texels_seen, 1.0));
        }
        surface.material.base_color *= textureColor(m, b0 * uv0 + b1 * uv1 + b2 * uv2, level);
    }
#endif
    return surface;
}

// Bilinear lookup; see brdf_albedo.h.
vec2 brdfAlbedo(float NoV, float roughness) {
    vec2 coord = albedoTableCoord(NoV, roughness);
    ivec2 i = min(ivec2(coord), ivec2(ALBEDO_TABLE_MU - 2, ALBEDO_TABLE_ROUGHNESS - 2));
    vec2 f = coord - vec2(i);
    int first = i.y * ALBEDO_TABLE_MU + i.x;
    vec2 lower = mix(albedo_table[first], albedo_table[first + 1], f.x);
    first += ALBEDO_TABLE_MU;
    vec2 upper = mix(albedo_table[first], albedo_table[first + 1], f.x);
    return mix(lower, upper, f.y);
}
