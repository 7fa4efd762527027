// Which triangle a texel sees: index + 1, 0 is left for none.
flat in uint first;
layout(location = 0) out uint triangle;

void main() {
    triangle = first + uint(gl_PrimitiveID) + 1u;
}
