// Which triangle a texel sees: index + 1, 0 is left for none.
layout(std430, binding = 1) readonly buffer Drawn { uint drawn[]; };  // by position in the draw
uniform int first_drawn;
layout(location = 0) out uint triangle;

void main() {
    triangle = drawn[first_drawn + gl_PrimitiveID] + 1u;
}
