// Which texel of which record's hemisphere a fragment is, and the ray it stands for.
#include "shared/view.glsl"

layout(std430, binding = 0) readonly buffer Views { View views[]; };  // [record][face]
layout(binding = 1) uniform usampler2D visibility;
uniform int tile_width;
uniform int face_count;
uniform vec4 faces[5];  // x, y, width, height of a face within a tile

struct GatherTexel {
    vec3 origin;
    vec3 direction;     // unit, through the texel's centre
    vec3 step_u;        // to the neighbouring texels, on the scale of direction
    vec3 step_v;
    float solid_angle;
};

// Triangle + 1, 0: nothing is seen.
uint visibleTriangle() {
    return texelFetch(visibility, ivec2(gl_FragCoord.xy), 0).x;
}

GatherTexel gatherTexel() {
    int record = int(gl_FragCoord.x) / tile_width;
    vec2 position = vec2(gl_FragCoord.x - float(record * tile_width), gl_FragCoord.y);
    int face = 0;
    for (int i = 1; i < face_count; ++i) {
        face = position.y >= faces[i].y ? i : face;
    }
    View view = views[record * face_count + face];
    vec2 size = faces[face].zw;
    vec3 toward = viewDirection(view, (position - faces[face].xy) / size * 2.0 - 1.0);
    float length2 = dot(toward, toward);
    // Its area on the plane at distance 1 over the distance cubed.
    float area = 4.0 * length(cross(view.right, view.up)) / (size.x * size.y);
    GatherTexel texel;
    texel.origin = view.origin;
    float scale = inversesqrt(length2);
    texel.direction = toward * scale;
    texel.step_u = view.right * (2.0 * scale / size.x);
    texel.step_v = view.up * (2.0 * scale / size.y);
    texel.solid_angle = area / (length2 * sqrt(length2));
    return texel;
}
