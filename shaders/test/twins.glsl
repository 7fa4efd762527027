// What every shared function says of made-up inputs, as one text for both languages: the tests run
// it in a shader and in C++ and compare.
#include "shared/sh.glsl"
#include "shared/brdf.glsl"
#include "shared/light.glsl"
#include "shared/texture.glsl"
#include "shared/record.glsl"
#include "shared/hemisphere.glsl"
#include "shared/view.glsl"

// One row of the test's image each; rows below TWIN_SH hold four coefficients of the basis.
const int TWIN_SH = 25;
const int TWIN_BRDF = 25;
const int TWIN_DIFFUSE = 26;
const int TWIN_F0 = 27;
const int TWIN_LOBE = 28;
const int TWIN_NORMAL = 29;
const int TWIN_WEIGHT = 30;
const int TWIN_IRRADIANCE = 31;
const int TWIN_PLANE = 32;
const int TWIN_PERSPECTIVE = 33;
const int TWIN_PARALLEL = 34;
const int TWIN_SPOT = 35;
const int TWIN_SUN = 36;
const int TWIN_TAPS = 37;
const int TWIN_FRACTION = 38;
const int TWIN_TEXEL = 39;
const int TWIN_COUNT = 40;

FN vec3 aboveHorizon(IN(vec4) v) {
    return vec3(v.x, v.y, abs(v.z));
}

FN Brdf twinBrdf(IN(vec4) c, IN(vec4) d) {
    MaterialParams m;
    m.base_color = abs(vec3(c));
    m.metallic = abs(d.x);
    m.specular_color = vec3(abs(c.w), 1.0f, 2.0f);
    m.specular = abs(d.y);
    m.emission = vec3(0.0f);
    m.roughness = abs(d.z);
    m.film = vec3(abs(c.x), 1.0f + abs(c.y), 1000.0f * abs(c.z));
    m.transmission = 0.25f * abs(c.w);
    return makeBrdf(m, abs(d.w), vec2(0.7f, 0.1f) * abs(d.w));
}

FN View twinView(IN(vec4) a, IN(vec4) b, IN(vec4) c, int kind) {
    View view;
    view.origin = vec3(b.w, c.w, a.w);
    view.near = 0.25f;
    view.right = vec3(a);
    view.kind = kind;
    view.up = vec3(b);
    view.texel_size = 0.0f;
    view.forward = vec3(c);
    view.coarser = 0;
    view.dual_right = vec3(a);
    view.pad1 = 0.0f;
    view.dual_up = vec3(b);
    view.pad2 = 0.0f;
    view.dual_forward = vec3(c);
    view.pad3 = 0.0f;
    return view;
}

FN PunctualLight twinLight(IN(vec4) a, IN(vec4) b, IN(vec4) c, int kind) {
    PunctualLight light;
    light.position = 3.0f * vec3(a.w, b.w, c.w);
    light.inverse_range = 0.2f;
    light.direction = vec3(a);
    light.spot_scale = 2.0f;
    light.intensity = abs(vec3(b));
    light.spot_offset = 0.5f;
    light.kind = kind;
    light.first_view = 0;
    light.cos_outer = -0.25f;
    light.view_tiles = 1;
    return light;
}

// a, b, c: unit vectors, w in [-1, 1]; d: in [-1, 1]^4.
FN vec4 twin(int which, IN(vec4) a, IN(vec4) b, IN(vec4) c, IN(vec4) d) {
    vec3 up = vec3(0.0f, 0.0f, 1.0f);
    if (which < TWIN_SH) {
        ShVector y = shBasis(vec3(a), SH_MAX_ORDER, shFactors());
        return vec4(y.c[4 * which], y.c[4 * which + 1], y.c[4 * which + 2], y.c[4 * which + 3]);
    }
    if (which == TWIN_BRDF) {
        return vec4(evalBrdf(twinBrdf(c, d), up, aboveHorizon(a), vec3(b)), 0.0f);
    }
    if (which == TWIN_DIFFUSE) {
        Brdf brdf = twinBrdf(c, d);
        return vec4(brdf.diffuse, brdf.alpha);
    }
    if (which == TWIN_F0) {
        Brdf brdf = twinBrdf(c, d);
        return vec4(brdf.f0, brdf.f90);
    }
    if (which == TWIN_LOBE) {
        vec2 coord = albedoTableCoord(d.x, d.y);
        vec2 params = albedoTableParams(int(coord.x), int(coord.y));
        return vec4(schlickWeight(d.z), alphaFromRoughness(d.w), params.x, params.y);
    }
    if (which == TWIN_NORMAL) {
        return vec4(shadingNormal(vec3(a), faceViewer(vec3(b), vec3(c)), vec3(c)),
                    filteredAlpha(alphaFromRoughness(d.w), abs(d.x), abs(d.y), d.z));
    }
    if (which == TWIN_WEIGHT) {
        WeightParams w;
        w.accuracy = 0.5f + 0.4f * d.w;
        w.normal_weight = 0.5f + 0.5f * c.w;
        w.slab = 0.3f;
        vec3 n_k = normalize(vec3(b) + 0.1f * vec3(a));
        return vec4(recordWeight(w, vec3(d), n_k, 1.0f + 0.5f * a.w, vec3(d) + 0.2f * vec3(c), vec3(b),
                                 0.01f),
                    recordWeight(w, vec3(d), n_k, 1.0f, vec3(d), n_k, 0.01f),
                    recordWeight(w, vec3(a), n_k, 0.3f, vec3(c), vec3(b), 0.01f), 0.0f);
    }
    if (which == TWIN_IRRADIANCE) {
        Record k;
        k.position = vec3(a);
        k.radius = 1.0f;
        k.normal = vec3(b);
        k.order = DIFFUSE_ORDER;
        k.tangent = vec3(c);
        k.sh_first = 0;
        k.irradiance = abs(vec3(d));
        k.rotation_r = vec3(a);
        k.rotation_g = 2.0f * vec3(b);
        k.rotation_b = vec3(d);
        k.translation_r = vec3(c);
        k.translation_g = vec3(d);
        k.translation_b = 0.1f * vec3(d);
        k.material = k.missed_r = k.missed_g = k.missed_b = k.pad0 = k.pad1 = k.pad2 = 0.0f;
        return vec4(recordIrradiance(k, vec3(a) + 0.3f * vec3(d), normalize(vec3(b) + 0.3f * vec3(c))),
                    0.0f);
    }
    if (which == TWIN_PLANE) {
        float x0 = 3.0f * d.x;
        float y0 = 3.0f * d.y;
        float x1 = x0 + 0.1f + abs(d.z);
        float y1 = y0 + 0.1f + abs(d.w);
        return vec4(planeSolidAngle(x0, y0, x1, y1), planeCosine(x0, y0, x1, y1),
                    borderCosine(7.0f * a.w, 0.5f + abs(b.w)), planeSolidAngleCorner(x1, y1));
    }
    if (which == TWIN_PERSPECTIVE) {
        View view = twinView(a, b, c, VIEW_PERSPECTIVE);
        return clipFromWorld(view, vec3(d)) + vec4(viewDirection(view, vec2(d)), 0.0f);
    }
    if (which == TWIN_PARALLEL) {
        return clipFromWorld(twinView(a, b, c, VIEW_PARALLEL), vec3(d));
    }
    if (which == TWIN_SPOT) {
        LightSample s = sampleLight(twinLight(a, b, c, LIGHT_SPOT), vec3(d));
        return vec4(s.irradiance, s.distance);
    }
    if (which == TWIN_SUN) {
        LightSample s = sampleLight(twinLight(a, b, c, LIGHT_DIRECTIONAL), vec3(d));
        return vec4(s.wi + s.irradiance, s.distance);
    }
    TextureTaps taps = textureTaps(3.0f * vec2(d), ivec2(7, 16), ivec2(int(3.0f * abs(a.w)), int(3.0f * abs(b.w))));
    if (which == TWIN_TAPS) {
        return vec4(float(taps.lower.x), float(taps.lower.y), float(taps.upper.x), float(taps.upper.y));
    }
    if (which == TWIN_FRACTION) {
        return vec4(taps.fraction.x, taps.fraction.y, 0.0f, 0.0f);
    }
    return vec4(float(wrapTexel(int(9.0f * a.w), 5, 2)), float(shIndex(3, -2)), 0.0f, 0.0f);
}
