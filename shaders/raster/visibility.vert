// Transforms a vertex into a view.
#include "shared/view.glsl"

layout(location = 0) in vec3 position;
layout(std430, binding = 0) readonly buffer Views { View views[]; };
uniform int view_index;

void main() {
    gl_Position = clipFromWorld(views[view_index], position);
}
