// What a record adds to the specular light of a glossy pixel: the convolution of one group of its
// coefficients with the pixel's lobe. Blending sums it over groups and records.
// GROUP 0: the first group, with gradients; 1: any other.
#include "shared/lobe.glsl"
#include "splat/fragment.glsl"

layout(binding = 2, rgba32i) readonly uniform iimageBuffer lobes;  // see PixelLobes

layout(location = 0) out vec4 out_specular;  // weight * the lobe's convolution

// Eight coefficients of a lobe, as they come out of a texel: two in an int.
struct Eight {
    vec4 even;
    vec4 odd;
};

Eight lobeAt(int texel) {
    ivec4 pairs = imageLoad(lobes, texel);
    return Eight(vec4((pairs << 16) >> 16), vec4(pairs >> 16));
}

// Convolves them with the record's, which lie in the same way: channels begin at values[first] and
// then every `stride`. (Constants, and no loop around the calls: llvmpipe reads flat inputs lane by
// lane where it does not know which.)
vec3 convolve(Eight b, int first, int stride) {
    return vec3(dot(b.even, values[first]) + dot(b.odd, values[first + 1]),
                dot(b.even, values[first + stride]) + dot(b.odd, values[first + stride + 1]),
                dot(b.even, values[first + 2 * stride]) +
                    dot(b.odd, values[first + 2 * stride + 1]));
}

void main() {
    Pixel pixel = weighPixel();
    if (pixel.weight <= 0.0) {
        discard;
    }
    int texel = pixel.lobe + int(values[1].w);
    Eight b0 = lobeAt(texel);
    Eight b1 = lobeAt(texel + 1);
#if GROUP == 0
    const int STRIDE = LOBE_FIRST_GROUP / 4;
    vec3 sum = convolve(b0, 3, STRIDE) + convolve(b1, 5, STRIDE);
    // Along the tangent and across it, eight coefficients and the ninth.
    const int GRADIENTS = 3 + 3 * STRIDE;
    vec3 along = convolve(b0, GRADIENTS, 2) + b1.even.x * values[GRADIENTS + 12].xyz;
    vec3 across = convolve(b0, GRADIENTS + 6, 2) + b1.even.x * values[GRADIENTS + 13].xyz;
    vec3 d = pixel.position - values[0].xyz;
    vec3 tangent = values[2].xyz;
    sum += dot(d, tangent) * along + dot(d, cross(values[1].xyz, tangent)) * across;
#else
    const int STRIDE = LOBE_NEXT_GROUP / 4;
    Eight b2 = lobeAt(texel + 2);
    vec3 sum = convolve(b0, 2, STRIDE) + convolve(b1, 4, STRIDE) + convolve(b2, 6, STRIDE);
#endif
    out_specular = vec4(pixel.weight / float(LOBE_STEPS) * sum, 0.0);
}
