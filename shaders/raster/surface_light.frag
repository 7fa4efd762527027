// Light that one texel of a triangle's surface scatters diffusely, on both of its sides, and emits.
#include "raster/direct.glsl"
#include "shared/surface_light.glsl"

layout(std430, binding = 7) readonly buffer LitTriangles { LitTriangle lit_triangles[]; };
layout(binding = 1) uniform usampler2D owners;  // triangle + 1, 0: no texel
uniform int target_width;
uniform int first_row;

layout(location = 0) out vec4 out_front;  // w: how much of the texel lies on the triangle
layout(location = 1) out vec4 out_back;

void main() {
    uint owner = texelFetch(owners, ivec2(gl_FragCoord.xy), 0).x;
    out_front = vec4(0.0);
    out_back = vec4(0.0);
    if (owner == 0u) {
        return;
    }
    PackedTriangle t = triangles[owner - 1u];
    LitTriangle lit = lit_triangles[owner - 1u];
    int size = 1 << lit.log2_size;
    // Level-0 texels of all triangles lie one after the other; the owner's begin at its
    // light_texel.
    int texel = (first_row + int(gl_FragCoord.y)) * target_width + int(gl_FragCoord.x) - int(t.light_texel);
    int i = texel % size;
    int j = texel / size;
    float inverse_size = 1.0 / float(size);
    float coverage = i + j < size - 1 ? 1.0 : (i + j == size - 1 ? 0.5 : 0.0);
    if (coverage == 0.0) {
        return;
    }
    // A texel cut by the hypotenuse is represented by the centroid of the part that is left.
    float offset = coverage == 1.0 ? 0.5 : 1.0 / 3.0;
    float b1 = (float(i) + offset) * inverse_size;
    float b2 = (float(j) + offset) * inverse_size;
    float b0 = 1.0 - b1 - b2;
    vec3 e1 = t.p1 - t.p0;
    vec3 e2 = t.p2 - t.p0;
    vec3 scaled_normal = cross(e1, e2);
    float area2 = length(scaled_normal);
    vec3 n_g = scaled_normal / area2;
    vec3 p = t.p0 + b1 * e1 + b2 * e2;
    vec3 n = interpolatedNormal(b0 * t.n0 + b1 * t.n1 + b2 * t.n2, n_g);
    n = dot(n, n_g) < 0.0 ? -n : n;
    PackedMaterial m = materials[t.material];
    vec3 base_color = m.params.base_color;
    if (m.texture_first >= 0) {
        vec2 uv0 = vec2(t.uv0_x, t.uv0_y);
        vec2 uv1 = vec2(t.uv1_x, t.uv1_y);
        vec2 uv2 = vec2(t.uv2_x, t.uv2_y);
        vec2 d1 = uv1 - uv0;
        vec2 d2 = uv2 - uv0;
        float texels_seen = abs(d1.x * d2.y - d1.y * d2.x) * inverse_size * inverse_size *
                            float(m.texture_width * m.texture_height);
        base_color *= textureColor(m, b0 * uv0 + b1 * uv1 + b2 * uv2,
                                   0.5 * log2(max(texels_seen, 1.0)));
    }
    vec3 front = vec3(0.0);
    vec3 back = vec3(0.0);
    for (int k = 0; k < light_count; ++k) {
        PunctualLight light = lights[k];
        LightSample l = sampleLight(light, p);
        // A light lights the side it is on, and only where both normals agree on that.
        float side = dot(n_g, l.wi) >= 0.0 ? 1.0 : -1.0;
        float NoL = side * dot(n, l.wi);
        if (NoL > 0.0) {
            vec3 lifted = liftToSurface(p, side * n_g, l.wi, t.lod_error);
            vec3 e = l.irradiance * (NoL * lightVisibility(light, lifted, side * n_g));
            front += side > 0.0 ? e : vec3(0.0);
            back += side > 0.0 ? vec3(0.0) : e;
        }
    }
    out_front = vec4(base_color / PI * front + m.params.emission, coverage);
    out_back = vec4(base_color / PI * back + m.params.emission, coverage);
}
