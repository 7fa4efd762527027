// What a record contributes to a pixel: its weight, irradiance times weight, and for glossy pixels
// the specular lobe's convolution times weight. Blending sums them over the records.
// GLOSSY 0: pixels of the diffuse class; 1: glossy pixels.
#include "shared/record.glsl"

layout(std430, binding = 0) readonly buffer Records { Record records[]; };
#if GLOSSY
layout(std430, binding = 2) readonly buffer Harmonics { float harmonics[]; };  // see ShLayout
layout(std430, binding = 3) readonly buffer Lobes { float lobes[]; };          // see PixelLobes
layout(binding = 2) uniform isampler2D lobe_first;
#endif
layout(binding = 0) uniform sampler2D positions;  // w: depth
layout(binding = 1) uniform sampler2D normals;    // w: the pixel's order, -1 without geometry
uniform float pixel_angle;
uniform float accuracy;
uniform float normal_weight;
uniform float slab;
flat in int record_index;

layout(location = 0) out vec4 out_irradiance;  // weight * irradiance, weight
layout(location = 1) out vec4 out_specular;    // weight * the lobe's convolution

void main() {
    ivec2 texel = ivec2(gl_FragCoord.xy);
    vec4 normal = texelFetch(normals, texel, 0);
    int order = int(normal.w);
#if GLOSSY
    if (order <= DIFFUSE_ORDER || order > records[record_index].order) {
        discard;
    }
#else
    if (order != DIFFUSE_ORDER) {
        discard;
    }
#endif
    vec4 position = texelFetch(positions, texel, 0);
    WeightParams weight = WeightParams(accuracy, normal_weight, slab);
    float w = recordWeight(weight, records[record_index].position, records[record_index].normal,
                           records[record_index].radius, position.xyz, normal.xyz,
                           position.w * pixel_angle);
    if (w <= 0.0) {
        discard;
    }
    Record k = records[record_index];
    out_irradiance = vec4(w * recordIrradiance(k, position.xyz, normal.xyz), w);
    out_specular = vec4(0.0);
#if GLOSSY
    vec3 d = position.xyz - k.position;
    float along_tangent = dot(d, k.tangent);
    float along_bitangent = dot(d, cross(k.normal, k.tangent));
    int stride = k.order * k.order;
    int gradient_order = min(k.order, SH_GRADIENT_ORDER);
    int gradient_stride = gradient_order * gradient_order;
    int count = order * order;
    int gradient_count = min(count, gradient_stride);
    int lobe = texelFetch(lobe_first, texel, 0).x;
    int value = k.sh_first;
    int tangent = value + 3 * stride;
    int bitangent = tangent + 3 * gradient_stride;
    vec3 sum = vec3(0.0);
    for (int i = 0; i < gradient_count; ++i) {
        vec3 c = vec3(harmonics[value + i], harmonics[value + stride + i],
                      harmonics[value + 2 * stride + i]);
        c += along_tangent * vec3(harmonics[tangent + i], harmonics[tangent + gradient_stride + i],
                                  harmonics[tangent + 2 * gradient_stride + i]);
        c += along_bitangent *
             vec3(harmonics[bitangent + i], harmonics[bitangent + gradient_stride + i],
                  harmonics[bitangent + 2 * gradient_stride + i]);
        sum += lobes[lobe + i] * c;
    }
    for (int i = gradient_count; i < count; ++i) {
        sum += lobes[lobe + i] * vec3(harmonics[value + i], harmonics[value + stride + i],
                                      harmonics[value + 2 * stride + i]);
    }
    out_specular = vec4(w * sum, 0.0);
#endif
}
