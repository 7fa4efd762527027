// Radiance that each texel of a batch of hemispheres receives from Lambertian surfaces: a fetch of
// the light they scatter, at the level whose texels are as large as what the hemisphere's texel
// sees. The fetch is the filter: hard light cannot alias. Tiles lie side by side, one a record.
#include "shared/surface_light.glsl"
#include "gather/texel.glsl"

layout(std430, binding = 7) readonly buffer LitTriangles { LitTriangle lit_triangles[]; };
layout(std430, binding = 8) readonly buffer SurfaceLight { uvec4 surface_light[]; };

layout(location = 0) out vec4 out_radiance;  // w: distance, 0 where nothing is seen

// Of the point where a ray meets the triangle's plane; q = cross(to_origin, e1).
vec2 barycentrics(vec3 direction, vec3 to_origin, vec3 q, vec3 e1, vec3 e2) {
    vec3 s = cross(direction, e2);
    float det = dot(e1, s);
    return vec2(dot(to_origin, s), dot(direction, q)) * (det == 0.0 ? 0.0 : 1.0 / det);
}

void main() {
    uint id = visibleTriangle();
    if (id == 0u) {
        out_radiance = vec4(0.0);
        return;
    }
    LitTriangle t = lit_triangles[id - 1u];
    if (t.lambertian == 0) {
        discard;
    }
    GatherTexel texel = gatherTexel();
    vec3 e1 = t.p1 - t.p0;
    vec3 e2 = t.p2 - t.p0;
    vec3 to_origin = texel.origin - t.p0;
    vec3 scaled_normal = cross(e1, e2);
    // Moeller-Trumbore for four rays spread over the texel: on a surface seen at a grazing angle
    // the texel's footprint is long and thin, and one square of the light kept there is not it.
    // A ray that leaves the triangle falls back to the middle one, which is known to hit it.
    vec3 q = cross(to_origin, e1);
    vec2 middle = barycentrics(texel.direction, to_origin, q, e1, e2);
    middle.x = clamp(middle.x, 0.0, 1.0);
    middle.y = clamp(middle.y, 0.0, 1.0 - middle.x);
    float level_offset = 0.5 * log2(0.25 * texel.solid_angle / length(scaled_normal)) +
                         float(t.log2_size) + 0.5;
    vec3 front = vec3(0.0);
    vec3 back = vec3(0.0);
    for (int k = 0; k < 4; ++k) {
        vec3 direction = texel.direction + (float(k & 1) * 0.5 - 0.25) * texel.step_u +
                         (float(k >> 1) * 0.5 - 0.25) * texel.step_v;
        vec2 b = barycentrics(direction, to_origin, q, e1, e2);
        b = min(b.x, b.y) < 0.0 || b.x + b.y > 1.0 ? middle : b;
        vec3 from_hit = to_origin - b.x * e1 - b.y * e2;
        // Area of the footprint: solid angle * distance^2 / cosine, and the level whose texels
        // have it.
        float distance2 = dot(from_hit, from_hit);
        float cosine = max(abs(dot(scaled_normal, from_hit)) *
                               inversesqrt(max(distance2 * dot(scaled_normal, scaled_normal), 1e-30)),
                           0.05);
        float level = 0.5 * log2(max(distance2 / cosine, 1e-30)) + level_offset;
        uvec4 halves = surface_light[t.first + surfaceLightTexel(t.log2_size,
                                                                 clamp(int(level), 0, t.log2_size),
                                                                 b.x, b.y)];
        front += vec3(unpackHalf2x16(halves.x), unpackHalf2x16(halves.y).x);
        back += vec3(unpackHalf2x16(halves.y).y, unpackHalf2x16(halves.z));
    }
    // The distance is that of the plane in the middle.
    float facing = dot(scaled_normal, to_origin);
    float along = dot(scaled_normal, texel.direction);
    float distance = along == 0.0 ? length(to_origin) : abs(facing / along);
    out_radiance = vec4(0.25 * (facing >= 0.0 ? front : back), distance);
}
