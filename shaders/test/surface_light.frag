// Unpacks the stored surface light, one texel a pixel, row by row: front, and back.
layout(std430, binding = 8) readonly buffer SurfaceLight { uvec4 surface_light[]; };
uniform int image_width;
uniform int count;
layout(location = 0) out vec4 out_front;
layout(location = 1) out vec4 out_back;

void main() {
    int index = int(gl_FragCoord.y) * image_width + int(gl_FragCoord.x);
    uvec4 halves = surface_light[min(index, count - 1)];
    out_front = vec4(unpackHalf2x16(halves.x), unpackHalf2x16(halves.y).x, 0.0);
    out_back = vec4(unpackHalf2x16(halves.y).y, unpackHalf2x16(halves.z), 0.0);
}
