// Radiance that each texel of a batch of hemispheres receives: what its middle sees, shaded where it
// is hit by direct light scattered once toward the record, and emission.
#include "raster/direct.glsl"

layout(binding = 1) uniform usampler2D visibility;  // triangle + 1, 0: nothing is seen

layout(location = 0) flat in vec3 origin;
layout(location = 1) flat in vec3 first;
layout(location = 2) flat in vec3 step_u;
layout(location = 3) flat in vec3 step_v;
layout(location = 4) flat in vec3 corner;

layout(location = 0) out vec4 out_radiance;  // w: distance, 0 where nothing is seen

void main() {
    uint id = texelFetch(visibility, ivec2(gl_FragCoord.xy), 0).x;
    if (id == 0u) {
        out_radiance = vec4(0.0);
        return;
    }
    vec2 place = gl_FragCoord.xy - corner.xy;
    vec3 toward = first + place.x * step_u + place.y * step_v;
    float inverse_length = inversesqrt(dot(toward, toward));
    // Its area on the plane at distance 1 over the distance cubed.
    float solid_angle = corner.z * inverse_length * inverse_length * inverse_length;
    Surface s = surfaceAt(id - 1u, origin, toward * inverse_length, solid_angle);
    vec3 wo = normalize(origin - s.p);
    out_radiance = vec4(directRadiance(s, wo, solid_angle) + s.material.emission, s.distance);
}
