// Radiance that each texel of a batch of hemispheres receives from Lambertian surfaces: a fetch of
// the light they scatter, at the level whose texels are as large as what the hemisphere's texel
// sees. The fetch is the filter: hard light cannot alias. Tiles lie side by side, one a record.
#include "shared/surface_light.glsl"
#include "gather/texel.glsl"

layout(std430, binding = 7) readonly buffer LitTriangles { LitTriangle lit_triangles[]; };
layout(std430, binding = 8) readonly buffer SurfaceLight { uvec4 surface_light[]; };

layout(location = 0) out vec4 out_radiance;  // w: distance, 0 where nothing is seen

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
    // Moeller-Trumbore; the triangle is known to be hit, so clamp what rounding left outside.
    vec3 s = cross(texel.direction, e2);
    float det = dot(e1, s);
    vec3 q = cross(to_origin, e1);
    float inverse_det = det == 0.0 ? 0.0 : 1.0 / det;
    float b1 = clamp(dot(to_origin, s) * inverse_det, 0.0, 1.0);
    float b2 = clamp(dot(texel.direction, q) * inverse_det, 0.0, 1.0 - b1);
    vec3 from_hit = to_origin - b1 * e1 - b2 * e2;
    float distance = length(from_hit);
    // Twice the area, signed by the side that is seen, times the distance and the cosine.
    vec3 scaled_normal = cross(e1, e2);
    float facing = dot(scaled_normal, from_hit);
    float area2 = length(scaled_normal);
    float cosine = max(abs(facing) / max(area2 * distance, 1e-30), 0.05);
    float footprint = texel.solid_angle * distance * distance / cosine;
    float texel_area = area2 * exp2(-2.0 * float(t.log2_size));
    int level = clamp(int(0.5 * log2(footprint / texel_area) + 0.5), 0, t.log2_size);
    uvec4 halves = surface_light[t.first + surfaceLightTexel(t.log2_size, level, b1, b2)];
    vec3 front = vec3(unpackHalf2x16(halves.x), unpackHalf2x16(halves.y).x);
    vec3 back = vec3(unpackHalf2x16(halves.y).y, unpackHalf2x16(halves.z));
    out_radiance = vec4(facing >= 0.0 ? front : back, distance);
}
