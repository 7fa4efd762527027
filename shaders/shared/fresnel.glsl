// How much light surfaces reflect at an angle: by Schlick's formula, and under a thin transparent
// film, where waves from its two sides interfere.
// Based on: [Sch94]; [BB17], as KHR_materials_iridescence of glTF has it: Schlick's reflectances
// for Fresnel's, one polarisation, two orders of interference.
#ifndef SHARED_FRESNEL_GLSL
#define SHARED_FRESNEL_GLSL

#include "shared/language.glsl"

// Weight of F90 in Schlick's Fresnel. [Sch94, eq. 15]
FN float schlickWeight(float VoH) {
    float m = clamp(1.0f - VoH, 0.0f, 1.0f);
    float m2 = m * m;
    return m2 * m2 * m;
}

// Of light that comes at that cosine to where media of these indices touch.
FN float reflectedBetween(float from, float to, float cosine) {
    float r = (to - from) / (to + from);
    return mix(r * r, 1.0f, schlickWeight(cosine));
}

// The Fourier transform of a Gaussian over wave numbers: of this integral, place and variance.
FN float gaussianWave(float integral, float place, float variance, float phase, float shift) {
    return integral * cos(place * phase + shift) * exp(-variance * phase * phase);
}

// What white light of waves that are `path` nanometres and a phase of `shift` apart is seen as, in
// linear Rec. 709: its cosine over the spectrum, weighed by the eye's sensitivities, four Gaussians
// over wave numbers [BB17], over the integral of that for Y.
FN vec3 interference(float path, float shift) {
    float phase = 2.0f * PI * 1e-9f * path;
    float x = gaussianWave(0.846590f, 1.6810e6f, 4.3278e9f, phase, shift) +
              gaussianWave(0.153868f, 2.2399e6f, 4.5282e9f, phase, shift);
    float y = gaussianWave(1.000222f, 1.7953e6f, 9.3046e9f, phase, shift);
    float z = gaussianWave(1.001122f, 2.2084e6f, 6.6121e9f, phase, shift);
    return vec3(3.2404542f * x - 1.5371385f * y - 0.4985314f * z,
                -0.9692660f * x + 1.8760108f * y + 0.0415560f * z,
                0.0556434f * x - 0.2040259f * y + 1.0572252f * z);
}

// What a film reflects of one channel of light.
struct FilmChannel {
    float plain;  // without interference
    vec2 waves;   // what its first and second order add at most
    float shift;  // of phase, by both reflections within the film
};

// Of a film of that index, at least 1, on a surface of reflectance `base_f0` in air; cosines outside
// and inside. Light that is reflected to and fro within it, by a geometric series.
FN FilmChannel filmChannel(float index, float cosine, float inner_cosine, float base_f0) {
    float root = sqrt(clamp(base_f0, 0.0f, 0.9999f));
    float base_index = (1.0f + root) / (1.0f - root);
    float r12 = reflectedBetween(1.0f, index, cosine);
    float t121 = 1.0f - r12;
    float r23 = reflectedBetween(index, base_index, inner_cosine);
    float r123 = clamp(r12 * r23, 1e-5f, 0.9999f);
    float inside = t121 * t121 * r23 / (1.0f - r123);
    float wave = (inside - t121) * sqrt(r123);
    FilmChannel c;
    c.plain = r12 + inside;
    c.waves = 2.0f * vec2(wave, wave * sqrt(r123));
    c.shift = base_index < index ? 0.0f : PI;
    return c;
}

// And of all three, for a film so many nanometres thick.
FN vec3 filmReflectance(float index, float nanometres, float cosine, IN(vec3) base_f0) {
    float inner_cosine = sqrt(1.0f - (1.0f - cosine * cosine) / (index * index));
    float path = min(2.0f * index * nanometres * inner_cosine, 1e9f);  // shows no colour
    FilmChannel r = filmChannel(index, cosine, inner_cosine, base_f0.x);
    FilmChannel g = filmChannel(index, cosine, inner_cosine, base_f0.y);
    FilmChannel b = filmChannel(index, cosine, inner_cosine, base_f0.z);
    vec3 first = vec3(interference(path, r.shift).x, interference(path, g.shift).y,
                      interference(path, b.shift).z);
    vec3 second = vec3(interference(2.0f * path, 2.0f * r.shift).x,
                       interference(2.0f * path, 2.0f * g.shift).y,
                       interference(2.0f * path, 2.0f * b.shift).z);
    vec3 sum = vec3(r.plain, g.plain, b.plain) + vec3(r.waves.x, g.waves.x, b.waves.x) * first +
               vec3(r.waves.y, g.waves.y, b.waves.y) * second;
    return clamp(sum, vec3(0.0f), vec3(1.0f));
}

// The reflectance at normal incidence by which Schlick's formula gives, for a viewer at that cosine
// and light that he sees mirrored, what the surface reflects under its film. `film`: how much of
// the surface has one, index and thickness. [glTF, KHR_materials_iridescence]
FN vec3 f0UnderFilm(IN(vec3) f0, IN(vec3) film, float NoV) {
    float grazing = min(schlickWeight(NoV), 0.99f);
    vec3 seen = filmReflectance(film.y, film.z, clamp(NoV, 0.0f, 1.0f), f0);
    vec3 with_film = max((seen - vec3(grazing)) / (1.0f - grazing), vec3(0.0f));
    return mix(f0, with_film, film.x);
}

#endif
