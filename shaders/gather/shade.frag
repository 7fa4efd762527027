// Radiance that each texel of a batch of hemispheres receives, from the visibility buffer: direct
// light scattered once toward the record, and emission. Tiles lie side by side, one a record.
#include "raster/direct.glsl"

layout(std430, binding = 0) readonly buffer Views { View views[]; };  // [record][face]
layout(binding = 1) uniform usampler2D visibility;
uniform int tile_width;
uniform int face_count;
uniform vec4 faces[5];  // x, y, width, height of a face within a tile

layout(location = 0) out vec4 out_radiance;  // w: distance, 0 where nothing is seen

void main() {
    uint id = texelFetch(visibility, ivec2(gl_FragCoord.xy), 0).x;
    out_radiance = vec4(0.0);
    if (id == 0u) {
        return;
    }
    int record = int(gl_FragCoord.x) / tile_width;
    vec2 texel = vec2(gl_FragCoord.x - float(record * tile_width), gl_FragCoord.y);
    int face = 0;
    for (int i = 1; i < face_count; ++i) {
        face = texel.y >= faces[i].y ? i : face;
    }
    View view = views[record * face_count + face];
    vec2 size = faces[face].zw;
    vec3 toward = viewDirection(view, (texel - faces[face].xy) / size * 2.0 - 1.0);
    float length2 = dot(toward, toward);
    // Solid angle of a texel: its area on the plane at distance |forward| over the distance cubed.
    float area = 4.0 * length(cross(view.right, view.up)) / (size.x * size.y);
    float solid_angle = area / (length2 * sqrt(length2));
    Surface s = surfaceAt(id - 1u, view.origin, normalize(toward), solid_angle);
    vec3 wo = normalize(view.origin - s.p);
    out_radiance = vec4(directRadiance(s, wo) + s.material.emission, s.distance);
}
