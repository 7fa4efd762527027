// Runs twin(): one row a function, one column an input.
#include "test/twins.glsl"

layout(std430, binding = 0) readonly buffer Inputs { vec4 inputs[]; };  // [column][4]
uniform int unused_uniform;
layout(location = 0) out vec4 out_value;

void main() {
    ivec2 texel = ivec2(gl_FragCoord.xy);
    int first = 4 * texel.x;
    out_value = twin(texel.y, inputs[first], inputs[first + 1], inputs[first + 2], inputs[first + 3]);
}
