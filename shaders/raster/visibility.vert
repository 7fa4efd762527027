// Transforms a vertex into a view; the first triangle of the draw's cluster comes per instance.
#include "shared/view.glsl"

layout(location = 0) in vec3 position;
layout(location = 1) in uint first_triangle;
layout(std430, binding = 0) readonly buffer Views { View views[]; };
uniform int view_index;
flat out uint first;

void main() {
    first = first_triangle;
    gl_Position = clipFromWorld(views[view_index], position);
}
