// One quad a record, over a rectangle of pixels that holds its region of influence. Everything that
// fragments need to know of the record goes with the quad, so that it is read once and not by each.
layout(binding = 0) uniform samplerBuffer quads;  // [record]: two corners in clip space; the
                                                  // record's class as a depth; values
uniform vec3 weight;  // accuracy, normal_weight, slab
flat out vec3 weight_params;
flat out vec4 values[VALUES];

void main() {
    int first = gl_InstanceID * (2 + VALUES);
    vec4 corners = texelFetch(quads, first);
    float depth = texelFetch(quads, first + 1).x;
    for (int i = 0; i < VALUES; ++i) {
        values[i] = texelFetch(quads, first + 2 + i);
    }
    weight_params = weight;
    gl_Position = vec4((gl_VertexID & 1) == 0 ? corners.x : corners.z,
                       (gl_VertexID & 2) == 0 ? corners.y : corners.w, depth, 1.0);
}
