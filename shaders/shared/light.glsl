// Punctual lights [glTF, KHR_lights_punctual] and where base-colour textures are read.
// The structs are laid out so that C++ arrays upload as std430 buffers unchanged.
#ifndef SHARED_LIGHT_GLSL
#define SHARED_LIGHT_GLSL

#include "shared/language.glsl"

const int LIGHT_POINT = 0;
const int LIGHT_SPOT = 1;
const int LIGHT_DIRECTIONAL = 2;

struct PunctualLight {
    vec3 position;        // world space; unused for directional lights
    float inverse_range;  // 1/range, 0: unlimited
    vec3 direction;       // unit, the way a spot or directional light shines
    float spot_scale;     // angular attenuation = clamp(cos * scale + offset)^2;
    vec3 intensity;       // candela (point, spot) or lux (directional), times colour
    float spot_offset;    // scale 0 and offset 1 where the light has no cone
    int kind;
    int first_view;       // its shadow maps: set when they are made
    float cos_outer;      // of a spot's cone; -1 otherwise
    int view_tiles;       // along a side of a directional light's map
};

struct LightSample {
    vec3 wi;           // unit, toward the light
    float distance;    // to the light; negative: infinitely far
    vec3 irradiance;   // on a surface facing the light, unshadowed
};

FN LightSample sampleLight(IN(PunctualLight) light, IN(vec3) p) {
    LightSample s;
    if (light.kind == LIGHT_DIRECTIONAL) {
        s.wi = -light.direction;
        s.distance = -1.0f;
        s.irradiance = light.intensity;
        return s;
    }
    vec3 to_light = light.position - p;
    float d2 = max(dot(to_light, to_light), 1e-30f);
    s.distance = sqrt(d2);
    s.wi = to_light / s.distance;
    float cone = clamp(dot(-s.wi, light.direction) * light.spot_scale + light.spot_offset, 0.0f, 1.0f);
    float in_range = s.distance * light.inverse_range;
    in_range = in_range * in_range;
    float window = clamp(1.0f - in_range * in_range, 0.0f, 1.0f);
    s.irradiance = light.intensity * (cone * cone * window / d2);
    return s;
}

#endif
