// The BRDF of the project, the same for the cache and for the reference:
//   f = (1 - metallic) base/pi (1 - E_spec(NoV)) + D V F
// GGX distribution, Smith height-correlated masking-shadowing, Schlick Fresnel,
// alpha = roughness^2. E_spec, the specular lobe's directional albedo, comes from a table over
// (NoV, roughness) split by Schlick's Fresnel into F0 * A + F90 * B. Light scattered more than once
// between microfacets is counted by making the lobe as much stronger (microfacetGain()).
// Based on: [WMLT07], [Hei14], [Sch94], [Tur19], the glTF 2.0 specification's appendix B.
#ifndef SHARED_BRDF_GLSL
#define SHARED_BRDF_GLSL

#include "shared/fresnel.glsl"
#include "shared/language.glsl"

// Below this roughness the lobe is narrower than float arithmetic on unit vectors resolves.
const float MIN_ROUGHNESS = 0.03f;
// Cosines are kept above this where they divide.
const float MIN_COSINE = 1e-4f;
// A shading normal is bent until it makes at least this cosine with the viewer.
const float MIN_VIEW_COSINE = 1e-2f;

// Size of the directional-albedo table; its axes are sqrt(NoV) and the root of roughness above
// MIN_ROUGHNESS, since a smooth surface's albedo follows alpha / NoV; samples at the ends.
const int ALBEDO_TABLE_MU = 64;
const int ALBEDO_TABLE_ROUGHNESS = 32;

// A surface's material as seen from one direction.
struct Brdf {
    vec3 diffuse;  // diffuse reflectance toward the viewer, 1/pi not included
    float alpha;   // GGX width
    vec3 f0;       // specular reflectance at normal incidence, times what scatters again
    float f90;     // and at grazing incidence
};

// What a material is made of, textures applied.
struct MaterialParams {
    vec3 base_color;
    float metallic;
    vec3 specular_color;  // KHR_materials_specular
    float specular;
    vec3 emission;        // radiance, nits
    float roughness;      // perceptual
    vec3 film;            // KHR_materials_iridescence: how much of it has one, index, nanometres
    float transmission;   // how much of what enters a dielectric passes: KHR_materials_transmission
};

// Continuous sample coordinates (x: NoV, y: roughness) in the albedo table, 0..size-1.
FN vec2 albedoTableCoord(float NoV, float roughness) {
    float above = clamp((roughness - MIN_ROUGHNESS) / (1.0f - MIN_ROUGHNESS), 0.0f, 1.0f);
    return vec2(sqrt(clamp(NoV, 0.0f, 1.0f)) * float(ALBEDO_TABLE_MU - 1),
                sqrt(above) * float(ALBEDO_TABLE_ROUGHNESS - 1));
}
// The inverse: NoV and roughness of a table sample.
FN vec2 albedoTableParams(int x, int y) {
    float root_mu = float(x) / float(ALBEDO_TABLE_MU - 1);
    float root_above = float(y) / float(ALBEDO_TABLE_ROUGHNESS - 1);
    return vec2(root_mu * root_mu,
                MIN_ROUGHNESS + (1.0f - MIN_ROUGHNESS) * root_above * root_above);
}

FN float alphaFromRoughness(float roughness) {
    float r = max(roughness, MIN_ROUGHNESS);
    return r * r;
}

// Half the cone's radius would do (below); half again as much halves what records still differ by.
const float FILTER_WIDTH = 0.75f;

// The width of a lobe as a ray sees it that stands for a cone of `solid_angle` and met the surface
// after `distance`, under a light `light_distance` away (negative: infinitely far). A highlight that
// is narrower than the cone is met by few rays, each of them far too bright; one as wide as the cone
// brings the same light on average and is met by all. Across the cone of radius r the half vector
// turns by half of r, and by half of r distance / light_distance as the light's direction changes.
FN float filteredAlpha(float alpha, float solid_angle, float distance, float light_distance) {
    float bend = light_distance < 0.0f ? 1.0f : 1.0f + distance / max(light_distance, 1e-30f);
    return max(alpha, min(FILTER_WIDTH * sqrt(solid_angle / PI) * bend, 1.0f));
}

// What light scattered more than once between microfacets adds to a lobe, as a factor of it: a lobe
// that loses none reflects E = A + B of constant light once, and each time that the rest of it meets
// the surface again it is coloured by f0. Where f0 is 1 all of the light leaves. [Tur19]
FN vec3 microfacetGain(IN(vec3) f0, IN(vec2) albedo_ab) {
    float once = max(albedo_ab.x + albedo_ab.y, MIN_COSINE);
    return vec3(1.0f) + f0 * max(1.0f / once - 1.0f, 0.0f);
}

// What a surface transmits is what it does not scatter, of the light that its lobe does not reflect.
// A film colours the lobe by the angle at which it is seen, whatever the half vector.
// `albedo_ab` is the albedo table at (NoV, roughness). f90 is one number for all channels, and so is
// its gain, by the mean f0. [glTF, KHR_materials_specular]
FN Brdf makeBrdf(IN(MaterialParams) m, float NoV, IN(vec2) albedo_ab) {
    Brdf b;
    vec3 dielectric_f0 = min(0.04f * m.specular_color, vec3(1.0f)) * m.specular;
    b.f0 = mix(dielectric_f0, m.base_color, m.metallic);
    b.f90 = mix(m.specular, 1.0f, m.metallic);
    if (m.film.x > 0.0f && m.film.z > 0.0f) {
        b.f0 = f0UnderFilm(b.f0, vec3(m.film.x * b.f90, m.film.y, m.film.z), NoV);
    }
    vec3 gain = microfacetGain(b.f0, albedo_ab);
    b.f0 *= gain;
    b.f90 *= (gain.x + gain.y + gain.z) / 3.0f;
    b.alpha = alphaFromRoughness(m.roughness);
    vec3 e_spec = b.f0 * albedo_ab.x + vec3(b.f90 * albedo_ab.y);
    b.diffuse = (1.0f - m.metallic) * (1.0f - m.transmission) * m.base_color * (vec3(1.0f) - e_spec);
    return b;
}

// GGX normal distribution. [WMLT07, eq. 33]
FN float distributionGgx(float NoH, float alpha) {
    float a2 = alpha * alpha;
    // 1 - NoH^2 (1 - a2), arranged so that it does not cancel near NoH = 1
    float d = (1.0f - NoH * NoH) + NoH * NoH * a2;
    return a2 / (PI * d * d);
}

// Height-correlated G2 / (4 NoL NoV). [Hei14, eq. 99]
FN float visibilitySmith(float NoV, float NoL, float alpha) {
    float a2 = alpha * alpha;
    float v = NoL * sqrt(NoV * NoV * (1.0f - a2) + a2);
    float l = NoV * sqrt(NoL * NoL * (1.0f - a2) + a2);
    return 0.5f / max(v + l, MIN_COSINE * MIN_COSINE);
}

// The specular term without its Fresnel factor, and Schlick's weight: f = value * mix(f0, f90, w).
FN vec2 specularLobe(float alpha, IN(vec3) n, IN(vec3) wo, IN(vec3) wi) {
    float NoV = max(dot(n, wo), MIN_COSINE);
    float NoL = dot(n, wi);
    if (NoL <= 0.0f) {
        return vec2(0.0f, 0.0f);
    }
    vec3 h = normalize(wo + wi);
    float NoH = clamp(dot(n, h), 0.0f, 1.0f);
    return vec2(distributionGgx(NoH, alpha) * visibilitySmith(NoV, NoL, alpha),
                schlickWeight(dot(wo, h)));
}

// The specular BRDF, 1/sr; the cosine is not included; 0 below the horizon of n.
FN vec3 evalSpecular(IN(Brdf) b, IN(vec3) n, IN(vec3) wo, IN(vec3) wi) {
    vec2 lobe = specularLobe(b.alpha, n, wo, wi);
    return (b.f0 + (vec3(b.f90) - b.f0) * lobe.y) * lobe.x;
}

// The whole BRDF, 1/sr; the cosine is not included; 0 below the horizon of n.
FN vec3 evalBrdf(IN(Brdf) b, IN(vec3) n, IN(vec3) wo, IN(vec3) wi) {
    if (dot(n, wi) <= 0.0f) {
        return vec3(0.0f);
    }
    vec3 diffuse = b.diffuse / PI;
    // Only a Lambertian surface has no reflectance at grazing incidence.
    return b.f90 == 0.0f && b.f0 == vec3(0.0f) ? diffuse : diffuse + evalSpecular(b, n, wo, wi);
}

// Two-sidedness: surfaces are opaque and shade on both sides. The geometric normal turned to the
// viewer (direction wo, from the surface).
FN vec3 faceViewer(IN(vec3) n_g, IN(vec3) wo) {
    return dot(n_g, wo) < 0.0f ? -n_g : n_g;
}

// The unit normal interpolated from a triangle's corners, whose sum is `sum`; `n_g` where they
// cancel each other.
FN vec3 interpolatedNormal(IN(vec3) sum, IN(vec3) n_g) {
    return length(sum) > 1e-6f ? normalize(sum) : n_g;
}

// A unit normal bent toward the viewer where it is turned away, so that
// dot(n, wo) >= MIN_VIEW_COSINE.
FN vec3 bentToViewer(IN(vec3) n, IN(vec3) n_g, IN(vec3) wo) {
    float NoV = dot(n, wo);
    if (NoV >= MIN_VIEW_COSINE) {
        return n;
    }
    vec3 side = n - NoV * wo;  // n without its part along wo
    float side_length = length(side);
    if (side_length < 1e-6f) {
        return n_g;
    }
    return MIN_VIEW_COSINE * wo +
           sqrt(1.0f - MIN_VIEW_COSINE * MIN_VIEW_COSINE) / side_length * side;
}

// The shading normal: the interpolated one on the side of `n_g` (already facing the viewer).
FN vec3 shadingNormal(IN(vec3) n_interpolated, IN(vec3) n_g, IN(vec3) wo) {
    return bentToViewer(dot(n_interpolated, n_g) < 0.0f ? -n_interpolated : n_interpolated, n_g, wo);
}

#endif
