// Transforms a vertex into a view.
#include "shared/view.glsl"

layout(location = 0) in vec3 position;
// The View, row by row: from a storage buffer each vertex would fetch it anew.
uniform vec4 rows[7];

void main() {
    View view;
    view.origin = rows[0].xyz;
    view.near = rows[0].w;
    view.kind = floatBitsToInt(rows[1].w);
    view.dual_right = rows[4].xyz;
    view.dual_up = rows[5].xyz;
    view.dual_forward = rows[6].xyz;
    gl_Position = clipFromWorld(view, position);
}
