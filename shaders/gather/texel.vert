// A quad for each face of each record's hemisphere, over its texels in the batch's image, where tiles
// lie side by side, one a record. What is the same for a whole face goes along flat: a fragment would
// look it up for each lane.
#include "shared/view.glsl"

layout(std430, binding = 0) readonly buffer Views { View views[]; };  // [record][face]
uniform vec2 image_size;  // of the batch
uniform float tile_width;
uniform int face_count;
uniform vec4 faces[5];  // x, y, width, height of a face within a tile

layout(location = 0) flat out vec3 origin;
layout(location = 1) flat out vec3 first;   // toward the face's first corner, not unit
layout(location = 2) flat out vec3 step_u;  // from texel to texel
layout(location = 3) flat out vec3 step_v;
layout(location = 4) flat out vec3 corner;  // of the face in the image; z: a texel's area at distance 1

void main() {
    vec4 face = faces[gl_InstanceID % face_count];
    View view = views[gl_InstanceID];
    face.x += tile_width * float(gl_InstanceID / face_count);
    origin = view.origin;
    first = viewDirection(view, vec2(-1.0));
    step_u = view.right * (2.0 / face.z);
    step_v = view.up * (2.0 / face.w);
    corner = vec3(face.xy, length(cross(step_u, step_v)));
    vec2 place = face.xy + vec2(gl_VertexID & 1, gl_VertexID >> 1) * face.zw;
    gl_Position = vec4(place / image_size * 2.0 - 1.0, 0.0, 1.0);
}
