// Textures: where a point of a surface finds its texels, and what these make of its material.
// Based on: the glTF 2.0 specification, KHR_texture_transform, KHR_materials_specular.
#ifndef SHARED_TEXTURE_GLSL
#define SHARED_TEXTURE_GLSL

#include "shared/brdf.glsl"

const int WRAP_REPEAT = 0;
const int WRAP_CLAMP = 1;
const int WRAP_MIRROR = 2;

FN int wrapTexel(int i, int size, int wrap) {
    if (wrap == WRAP_CLAMP) {
        return clamp(i, 0, size - 1);
    }
    int period = wrap == WRAP_MIRROR ? 2 * size : size;
    // In GLSL % of a negative number is undefined.
    int j = i < 0 ? period - 1 - (-1 - i) % period : i % period;
    return j < size ? j : period - 1 - j;
}

// The four texels of a bilinear lookup, and the fraction between them.
struct TextureTaps {
    ivec2 lower;
    ivec2 upper;
    vec2 fraction;
};

// uv as in glTF: (0, 0) is the corner of the first texel of the first row. What a transform of the
// coordinates makes infinite, or no number, counts as 0.
FN TextureTaps textureTaps(IN(vec2) uv_, IN(ivec2) size, IN(ivec2) wrap) {
    TextureTaps taps;
    const float largest = 3e38f;
    vec2 uv = vec2(abs(uv_.x) < largest ? uv_.x : 0.0f, abs(uv_.y) < largest ? uv_.y : 0.0f);
    // Keep the fraction exact for far-out coordinates; mirrored wrapping has period 2.
    vec2 reduced = uv - 2.0f * floor(0.5f * uv);
    vec2 base = vec2(wrap.x == WRAP_CLAMP ? clamp(uv.x, 0.0f, 1.0f) : reduced.x,
                     wrap.y == WRAP_CLAMP ? clamp(uv.y, 0.0f, 1.0f) : reduced.y);
    vec2 t = base * vec2(size) - vec2(0.5f);
    vec2 cell = floor(t);
    taps.fraction = t - cell;
    ivec2 i = ivec2(cell);
    taps.lower = ivec2(wrapTexel(i.x, size.x, wrap.x), wrapTexel(i.y, size.y, wrap.y));
    taps.upper = ivec2(wrapTexel(i.x + 1, size.x, wrap.x), wrapTexel(i.y + 1, size.y, wrap.y));
    return taps;
}

// The one texel that uv lies in, in the same form.
FN TextureTaps nearestTaps(IN(vec2) uv, IN(ivec2) size, IN(ivec2) wrap) {
    TextureTaps taps = textureTaps(uv, size, wrap);
    taps.lower.x = taps.fraction.x < 0.5f ? taps.lower.x : taps.upper.x;
    taps.lower.y = taps.fraction.y < 0.5f ? taps.lower.y : taps.upper.y;
    taps.upper = taps.lower;
    taps.fraction = vec2(0.0f);
    return taps;
}

// The area of a surface that a cone of `solid_angle` meets after `distance`, where it makes this
// cosine with the normal. Below the least cosine it grows no more: the far end is another surface.
FN float footprintArea(float solid_angle, float distance, float cosine) {
    const float least_cosine = 0.05f;
    return solid_angle * distance * distance / max(abs(cosine), least_cosine);
}

// Which of an image's levels, each half the size of the one before, has texels as large as a
// footprint, which is this share of twice the area of a triangle with edges d1 and d2 in texture
// coordinates: 0 is the image itself. By area alone, so that what is seen at an angle is sharper
// along it, and blurred across, than its footprint is long and wide. [AMNSA19]
FN float textureLevel(float footprint_over_area2, IN(vec2) d1, IN(vec2) d2, IN(ivec2) size) {
    float texels =
        footprint_over_area2 * abs(d1.x * d2.y - d1.y * d2.x) * float(size.x) * float(size.y);
    return texels > 1.0f ? 0.5f * log2(texels) : 0.0f;
}

// Texture coordinates as one of a material's textures takes them. [KHR_texture_transform]
struct TextureTransform {
    vec2 row_u;
    vec2 row_v;
    vec2 offset;
};

FN vec2 transformedUv(IN(TextureTransform) t, IN(vec2) uv) {
    return vec2(dot(t.row_u, uv), dot(t.row_v, uv)) + t.offset;
}

// What a material's textures are for.
const int TEXTURE_BASE_COLOR = 0;
const int TEXTURE_METALLIC_ROUGHNESS = 1;  // green: roughness, blue: metallic
const int TEXTURE_EMISSION = 2;
const int TEXTURE_SPECULAR = 3;  // alpha
const int TEXTURE_SPECULAR_COLOR = 4;
const int TEXTURE_TRANSMISSION = 5;  // red
const int TEXTURE_FILM = 6;          // red
const int TEXTURE_FILM_THICKNESS = 7;  // green
const int TEXTURE_USES = 8;

// The material with a texel of one of its textures, linear light, applied: a factor.
FN MaterialParams withTexel(IN(MaterialParams) material, int use, IN(vec4) texel) {
    MaterialParams m = material;
    vec3 color = vec3(texel.x, texel.y, texel.z);
    if (use == TEXTURE_BASE_COLOR) {
        m.base_color *= color;
    } else if (use == TEXTURE_METALLIC_ROUGHNESS) {
        m.roughness *= texel.y;
        m.metallic *= texel.z;
    } else if (use == TEXTURE_EMISSION) {
        m.emission *= color;
    } else if (use == TEXTURE_SPECULAR) {
        m.specular *= texel.w;
    } else if (use == TEXTURE_SPECULAR_COLOR) {
        m.specular_color *= color;
    } else if (use == TEXTURE_TRANSMISSION) {
        m.transmission *= texel.x;
    } else if (use == TEXTURE_FILM) {
        m.film.x *= texel.x;
    } else {
        m.film.z *= texel.y;
    }
    return m;
}

// The shading normal by a normal map. `tangent`: interpolated from the corners, w the bitangent's
// sign; `texel`: as stored, (x, y) scaled by `scale`. Seen from the back all three axes turn over,
// as in three.js. Where there is no tangent the surface stays smooth.
FN vec3 mappedNormal(IN(vec3) n_interpolated, IN(vec4) tangent, IN(vec4) texel, float scale,
                     IN(vec3) n_g, IN(vec3) wo) {
    vec3 along = vec3(tangent.x, tangent.y, tangent.z);
    float tangent_length = length(along);
    if (!(tangent_length > 1e-6f)) {
        return shadingNormal(n_interpolated, n_g, wo);
    }
    vec3 t = along / tangent_length;
    vec3 b = cross(n_interpolated, t) * (tangent.w < 0.0f ? -1.0f : 1.0f);
    vec3 m = scale * (2.0f * texel.x - 1.0f) * t + scale * (2.0f * texel.y - 1.0f) * b +
             (2.0f * texel.z - 1.0f) * n_interpolated;
    float side = dot(n_interpolated, n_g) < 0.0f ? -1.0f : 1.0f;
    float m_length = length(m);
    return m_length > 1e-6f ? bentToViewer(side / m_length * m, n_g, wo)
                            : shadingNormal(n_interpolated, n_g, wo);
}

// The material with a vertex colour applied. An unlit one has its colour as emission.
FN MaterialParams withVertexColor(IN(MaterialParams) material, IN(vec3) color, bool unlit) {
    MaterialParams m = material;
    m.base_color *= color;
    m.emission *= unlit ? color : vec3(1.0f);
    return m;
}

#endif
