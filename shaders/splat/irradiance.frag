// What a record adds to a pixel's irradiance; blending sums it over the records.
#include "splat/fragment.glsl"

layout(location = 0) out vec4 out_irradiance;  // weight * irradiance, weight

void main() {
    Pixel pixel = weighPixel();
    if (pixel.weight <= 0.0) {
        discard;
    }
    Record k;  // its values are the quad's, but for integers and padding
    k.position = values[0].xyz;
    k.normal = values[1].xyz;
    k.irradiance = values[3].xyz;
    k.rotation_r = values[4].xyz;
    k.rotation_g = values[5].xyz;
    k.rotation_b = values[6].xyz;
    k.translation_r = values[7].xyz;
    k.translation_g = values[8].xyz;
    k.translation_b = values[9].xyz;
    vec3 irradiance = recordIrradiance(k, pixel.position, pixel.normal);
    out_irradiance = vec4(pixel.weight * irradiance, pixel.weight);
}
