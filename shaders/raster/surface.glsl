// The scene as the shaders see it: from a triangle index and a ray to the surface that was hit.
// Positions come from the ray and the triangle, not from a depth buffer, so that they are as exact
// as single precision allows.
#include "shared/brdf.glsl"
#include "shared/light.glsl"
#include "shared/texture.glsl"

struct PackedTriangle {
    vec3 p0; uint material;
    vec3 p1; float uv0_x;
    vec3 p2; float uv0_y;
    vec3 n0; float uv1_x;
    vec3 n1; float uv1_y;
    vec3 n2; float uv2_x;
    float uv2_y; uint pad1; float lod_error; float pad0;
};
struct PackedTexture {
    TextureTransform transform;
    int uv_set;
    int first;    // texel index of level 0, -1: no texture
    int levels;
    int nearest;  // not interpolated
    ivec2 size;
    ivec2 wrap;
    ivec2 pad;
};
struct PackedMaterial {
    MaterialParams params;
    int unlit;
    float normal_scale;
    int pad0;
    int pad1;
    PackedTexture textures[TEXTURE_USES + 1];  // the last: the normal's
};
struct PackedCorner {
    vec4 color;
    vec4 tangent;
    vec2 second_uv;
    vec2 pad;
};
layout(std430, binding = 1) readonly buffer Triangles { PackedTriangle triangles[]; };
layout(std430, binding = 2) readonly buffer Materials { PackedMaterial materials[]; };
layout(std430, binding = 3) readonly buffer Texels { uvec2 texels[]; };
layout(std430, binding = 4) readonly buffer Lights { PunctualLight lights[]; };
layout(std430, binding = 5) readonly buffer AlbedoTable { vec2 albedo_table[]; };
layout(std430, binding = 7) readonly buffer Corners { PackedCorner corners[]; };  // three a triangle
uniform int light_count;

struct Surface {
    vec3 p;          // world space
    float distance;  // from the ray's origin
    vec3 n_g;        // geometric normal, facing the viewer
    vec3 n;          // shading normal
    MaterialParams material;
    float lod_error; // how far the true surface may lie from p
};

vec4 texelAt(int index) {
    uvec2 halves = texels[index];
    return vec4(unpackHalf2x16(halves.x), unpackHalf2x16(halves.y));
}

// `m.textures[use]` is never copied: it would cost more than the look-up.
vec4 texelOfLevel(uint material, int use, vec2 uv, int steps) {
    int first = materials[material].textures[use].first;
    ivec2 size = materials[material].textures[use].size;
    ivec2 wrap = materials[material].textures[use].wrap;
    for (int i = 0; i < steps; ++i) {
        first += size.x * size.y;
        size = max(size / 2, ivec2(1));
    }
    if (materials[material].textures[use].nearest != 0 && steps == 0) {
        ivec2 at = nearestTaps(uv, size, wrap).lower;
        return texelAt(first + at.y * size.x + at.x);
    }
    TextureTaps t = textureTaps(uv, size, wrap);
    vec4 lower = mix(texelAt(first + t.lower.y * size.x + t.lower.x),
                     texelAt(first + t.lower.y * size.x + t.upper.x), t.fraction.x);
    vec4 upper = mix(texelAt(first + t.upper.y * size.x + t.lower.x),
                     texelAt(first + t.upper.y * size.x + t.upper.x), t.fraction.x);
    return mix(lower, upper, t.fraction.y);
}

// Linear between levels, as sampled() in scene/texture.h.
vec4 texelOf(uint material, int use, vec2 uv, float level) {
    float clamped = clamp(level, 0.0, float(materials[material].textures[use].levels - 1));
    int finer = int(clamped);
    vec4 fine = texelOfLevel(material, use, uv, finer);
    float rest = clamped - float(finer);
    return rest > 0.0 ? mix(fine, texelOfLevel(material, use, uv, finer + 1), rest) : fine;
}

// A triangle's corners as one of its material's textures takes them.
struct CornerUvs {
    vec2 uv0;
    vec2 uv1;
    vec2 uv2;
};

CornerUvs cornerUvs(uint triangle, uint material, int use) {
    PackedTriangle t = triangles[triangle];
    CornerUvs c = CornerUvs(vec2(t.uv0_x, t.uv0_y), vec2(t.uv1_x, t.uv1_y), vec2(t.uv2_x, t.uv2_y));
#ifdef CORNERS
    if (materials[material].textures[use].uv_set == 1) {
        c = CornerUvs(corners[3u * triangle].second_uv, corners[3u * triangle + 1u].second_uv,
                      corners[3u * triangle + 2u].second_uv);
    }
#endif
    TextureTransform transform = materials[material].textures[use].transform;
    return CornerUvs(transformedUv(transform, c.uv0), transformedUv(transform, c.uv1),
                     transformedUv(transform, c.uv2));
}

// One of a material's textures at barycentric coordinates `b` of a triangle.
// `footprint_over_area2` is what a look stands for, of twice the triangle's area; 0 reads the finest
// level.
vec4 textureAt(uint triangle, uint material, int use, vec3 b, float footprint_over_area2) {
    CornerUvs c = cornerUvs(triangle, material, use);
    float level = 0.0;
    if (footprint_over_area2 > 0.0) {
        level = textureLevel(footprint_over_area2, c.uv1 - c.uv0, c.uv2 - c.uv0,
                             materials[material].textures[use].size);
    }
    return texelOf(material, use, b.x * c.uv0 + b.y * c.uv1 + b.z * c.uv2, level);
}

MaterialParams materialAt(uint triangle, uint material, vec3 b, float footprint_over_area2) {
    MaterialParams params = materials[material].params;
#ifdef TEXTURED
    for (int use = 0; use < TEXTURE_USES; ++use) {
        if (materials[material].textures[use].first >= 0) {
            params = withTexel(params, use,
                               textureAt(triangle, material, use, b, footprint_over_area2));
        }
    }
#endif
#ifdef CORNERS
    vec4 color = b.x * corners[3u * triangle].color + b.y * corners[3u * triangle + 1u].color +
                 b.z * corners[3u * triangle + 2u].color;
    params = withVertexColor(params, vec3(color), materials[material].unlit != 0);
#endif
    return params;
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
    float footprint =
        footprintArea(texel_solid_angle, surface.distance, dot(surface.n_g, wo));
    vec3 b = vec3(b0, b1, b2);
    surface.material = materialAt(triangle, t.material, b, footprint / area2);
#if defined(TEXTURED) && defined(CORNERS)
    if (materials[t.material].textures[TEXTURE_USES].first >= 0) {
        vec4 tangent = b.x * corners[3u * triangle].tangent +
                       b.y * corners[3u * triangle + 1u].tangent +
                       b.z * corners[3u * triangle + 2u].tangent;
        vec4 texel = textureAt(triangle, t.material, TEXTURE_USES, b, footprint / area2);
        surface.n = mappedNormal(n, tangent, texel, materials[t.material].normal_scale,
                                 surface.n_g, wo);
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
