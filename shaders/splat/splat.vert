// One quad a record, over the rectangle of pixels that bounds its region of influence.
layout(std430, binding = 1) readonly buffer Rects { ivec4 rects[]; };  // x0, y0, x1, y1
uniform vec2 image_size;
flat out int record_index;

void main() {
    record_index = gl_InstanceID;
    ivec4 r = rects[gl_InstanceID];
    vec2 corner = vec2((gl_VertexID & 1) == 0 ? r.x : r.z, (gl_VertexID & 2) == 0 ? r.y : r.w);
    gl_Position = vec4(corner / image_size * 2.0 - 1.0, 0.0, 1.0);
}
