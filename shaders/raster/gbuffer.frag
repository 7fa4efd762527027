// Direct light on what the pixels see.
#include "raster/direct.glsl"

layout(std430, binding = 0) readonly buffer Views { View views[]; };
layout(binding = 1) uniform usampler2D visibility;  // triangle + 1, 0: none
uniform vec2 image_size;

layout(location = 0) out vec4 out_direct;  // radiance

void main() {
    uint id = texelFetch(visibility, ivec2(gl_FragCoord.xy), 0).x;
    out_direct = vec4(0.0);
    if (id == 0u) {
        return;
    }
    View view = views[0];
    vec2 uv = gl_FragCoord.xy / image_size * 2.0 - 1.0;
    vec3 toward = viewDirection(view, uv);
    // A pixel's area on the plane at distance 1 over the distance cubed.
    float solid_angle = 4.0 * length(view.right) * length(view.up) /
                        (image_size.x * image_size.y * pow(dot(toward, toward), 1.5));
    Surface s = surfaceAt(id - 1u, view.origin, normalize(toward), solid_angle);
    out_direct = vec4(directRadiance(s, normalize(view.origin - s.p), 0.0), 0.0);
}
