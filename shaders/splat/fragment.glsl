// The pixel and the record that a fragment brings together. The depth test, which compares classes,
// has let only those through where the record's class serves the pixel's.
#include "shared/record.glsl"

layout(early_fragment_tests) in;
layout(binding = 0, rgba32f) readonly uniform image2D positions;  // w: footprint
layout(binding = 1, rgba32ui) readonly uniform uimage2D normals;  // bits of floats; w: first texel
                                                                  // of the pixel's lobe
flat in vec3 weight_params;   // accuracy, normal_weight, slab
flat in vec4 values[VALUES];  // position, radius; normal, and of specular passes the
                              // group's first texel; then what the pass needs

struct Pixel {
    vec3 position;
    vec3 normal;
    int lobe;
    float weight;  // of the record
};

Pixel weighPixel() {
    ivec2 texel = ivec2(gl_FragCoord.xy);
    vec4 position = imageLoad(positions, texel);
    uvec4 normal = imageLoad(normals, texel);
    Pixel pixel = Pixel(position.xyz, uintBitsToFloat(normal.xyz), int(normal.w), 0.0);
    pixel.weight = recordWeight(WeightParams(weight_params.x, weight_params.y, weight_params.z),
                                values[0].xyz, values[1].xyz, values[0].w, pixel.position,
                                pixel.normal, position.w);
    return pixel;
}
