// Direct light of the punctual lights, shadowed by shadow maps.
// Based on: [Wil78], [RSC87] for percentage-closer filtering.
#include "shared/view.glsl"
#include "raster/surface.glsl"

layout(std430, binding = 6) readonly buffer ShadowViews { View shadow_views[]; };
layout(binding = 0) uniform sampler2DArrayShadow shadow_maps;
uniform float shadow_resolution;

// Added to the lift below, for what is not flat, and how much nearer to a light that shines from a
// point its shadow is looked up; texels.
const float LEAST_LIFT = 0.1;
const float NEARER = 3.0;

// Which of a point light's six views sees a point in direction d: the major axis.
int cubeFace(vec3 d) {
    vec3 a = abs(d);
    if (a.x >= a.y && a.x >= a.z) {
        return d.x >= 0.0 ? 0 : 1;
    }
    if (a.y >= a.z) {
        return d.y >= 0.0 ? 2 : 3;
    }
    return d.z >= 0.0 ? 4 : 5;
}

// Which of a directional light's views sees p; `first` is the one at the corner.
int sunTile(View first, vec3 p, int tiles) {
    vec2 c = viewCoordinates(first, p).xy * SHADOW_MARGIN;  // [-1, 1]: the first tile without margin
    ivec2 tile = clamp(ivec2(floor(0.5 * c + 0.5)), ivec2(0), ivec2(tiles - 1));
    return tile.y * tiles + tile.x;
}

// Whether a directional light's view has p, with what the filter reads around it.
bool holds(View view, vec3 p) {
    vec3 c = viewCoordinates(view, p);
    return max(abs(c.x), abs(c.y)) * SHADOW_MARGIN < 1.0 && c.z > 0.0 && c.z < 1.0;
}

// Fraction of the light that reaches p, whose geometric normal n_g faces it. The receiver is lifted
// along its normal by what a tilted surface varies across the filter's footprint, so that a surface
// never shadows itself: by half the footprint times the sine of its tilt against the map's plane.
// Light that comes from a point is then compared a few texels nearer to it, so that two surfaces
// that meet in a hollow edge do not shadow each other there.
float lightVisibility(PunctualLight light, vec3 p, vec3 n_g) {
    int index = light.first_view;
    if (light.kind == LIGHT_POINT || (light.kind == LIGHT_SPOT && light.cos_outer < SPOT_CUBE_COSINE)) {
        index += cubeFace(p - light.position);
    }
    if (light.kind == LIGHT_DIRECTIONAL && light.view_tiles > 1) {
        index += sunTile(shadow_views[index], p, light.view_tiles);
    }
    View view = shadow_views[index];
    while (view.coarser != 0 && !holds(view, p)) {
        index = view.coarser;
        view = shadow_views[index];
    }
    float along = dot(view.dual_forward, p - view.origin);
    float texel = view.texel_size * (view.kind == VIEW_PARALLEL ? 1.0 : along);
    float tilt = length(cross(n_g, normalize(view.forward)));
    float lift = texel * (SHADOW_LIFT_TEXELS * tilt + LEAST_LIFT);
    vec4 clip = clipFromWorld(view, p + n_g * lift);
    vec3 ndc = clip.xyz / clip.w;
    vec2 uv = 0.5 * ndc.xy + 0.5;
    float depth = view.kind == VIEW_PARALLEL ? ndc.z + 4e-7 : ndc.z * (1.0 + NEARER * view.texel_size);
    float layer = float(index);
#if SHADOW_TAPS == 1
    return texture(shadow_maps, vec4(uv, layer, depth));
#else
    // Four bilinear comparisons, a texel apart: a tent three texels wide.
    float o = 0.5 / shadow_resolution;
    return 0.25 * (texture(shadow_maps, vec4(uv + vec2(-o, -o), layer, depth)) +
                   texture(shadow_maps, vec4(uv + vec2(o, -o), layer, depth)) +
                   texture(shadow_maps, vec4(uv + vec2(-o, o), layer, depth)) +
                   texture(shadow_maps, vec4(uv + vec2(o, o), layer, depth)));
#endif
}

// Where a point of simplified geometry looks for light: it may lie below the true surface, which
// casts the shadows, by as much as the simplification's error.
vec3 liftToSurface(vec3 p, vec3 n_g, vec3 wi, float lod_error) {
    return p + lod_error * (2.0 * n_g + 3.0 * wi);
}

// Radiance toward wo of light scattered once, as seen by a ray that stands for `solid_angle` (0: for
// itself). LAMBERTIAN: where all surfaces are.
vec3 directRadiance(Surface s, vec3 wo, float solid_angle) {
#ifndef LAMBERTIAN
    float NoV = max(dot(s.n, wo), MIN_COSINE);
    Brdf brdf = makeBrdf(s.material, NoV, brdfAlbedo(NoV, s.material.roughness));
    float alpha = brdf.alpha;
#endif
    vec3 sum = vec3(0.0);
    for (int i = 0; i < light_count; ++i) {
        PunctualLight light = lights[i];
        LightSample l = sampleLight(light, s.p);
        float NoL = dot(s.n, l.wi);
        if (NoL > 0.0 && dot(s.n_g, l.wi) > 0.0) {
            vec3 p = liftToSurface(s.p, s.n_g, l.wi, s.lod_error);
#ifdef LAMBERTIAN
            vec3 f = s.material.base_color / PI;
#else
            brdf.alpha = filteredAlpha(alpha, solid_angle, s.distance, l.distance);
            vec3 f = evalBrdf(brdf, s.n, wo, l.wi);
#endif
            sum += f * l.irradiance * (NoL * lightVisibility(light, p, s.n_g));
        }
    }
    return sum;
}
