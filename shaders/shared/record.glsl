// A record of the cache and how it serves a point: weight and extrapolation, the same on CPU and GPU.
// Based on: [WRC88], [GKB09, 8.1-8.2], [WH92].
#ifndef SHARED_RECORD_GLSL
#define SHARED_RECORD_GLSL

#include "shared/language.glsl"

// A point is covered when its weights sum to at least this. (A test for exactly zero would differ
// between CPU and GPU and leave black pixels.)
const float MIN_WEIGHT_SUM = 0.05f;

// Order of records that hold irradiance only.
const int DIFFUSE_ORDER = 0;

struct Record {
    vec3 position;        // world space
    float radius;         // R of the weight function, after all clamps
    vec3 normal;          // unit
    int order;            // of its spherical harmonics; DIFFUSE_ORDER: none
    vec3 tangent;         // unit; SH gradients are along it and along cross(normal, tangent)
    int sh_first;         // index of its first SH coefficient
    vec3 irradiance;      // RGB, W/m^2 in glTF's photometric scale (lux)
    float material;       // index of its surface's; whole numbers are exact to 2^24
    vec3 rotation_r;      // per channel: change of irradiance is dot(n - n_k, rotation)
    float missed_r;       // RGB: radiance that the specular lobe of its own pixel sees, on average,
    vec3 rotation_g;
    float missed_g;       // more than by its coefficients or, where it has none, than by its
    vec3 rotation_b;
    float missed_b;       // irradiance over pi
    vec3 translation_r;   // per channel: change is dot(p - p_k, translation); tangential
    float pad0;
    vec3 translation_g;
    float pad1;
    vec3 translation_b;
    float pad2;
};

struct WeightParams {
    float accuracy;       // a
    float normal_weight;  // k_n: how much a tilt counts against a distance
    float slab;           // c: half-thickness of the region served, relative to a R
};

// Weight of a record with radius R at p_k, n_k for the point p, n: positive where it serves, 0
// elsewhere. `footprint` is the width of the point's pixel: closer than half of it all points are
// the same, which keeps the weight finite. [GKB09, eq. 8.2, and the shift of section 8.2]
FN float recordWeight(IN(WeightParams) w, IN(vec3) p_k, IN(vec3) n_k, float R, IN(vec3) p, IN(vec3) n,
                      float footprint) {
    vec3 d = p - p_k;
    float reach = w.accuracy * R;
    float d2 = dot(d, d);
    if (d2 >= reach * reach) {
        return 0.0f;
    }
    // In front of or behind the surface both normals agree on: another surface. Two-sided, and
    // relative to the region's size so that it holds in scenes of any scale.
    if (0.5f * abs(dot(d, n + n_k)) > w.slab * reach) {
        return 0.0f;
    }
    // 1 - n.n_k of unit vectors is half of |n - n_k|^2, which is 0 where they are the same: the root of
    // a rounding error would weigh as much as the way to the next pixel.
    vec3 dn = n - n_k;
    float e = sqrt(d2) / R + sqrt(0.5f * w.normal_weight * dot(dn, dn));
    float e_min = 0.5f * footprint / R;
    return max(w.accuracy / max(e, e_min) - 1.0f, 0.0f);
}

// What the lobe of its own pixel sees more than the record says otherwise; may be negative.
FN vec3 recordMissed(IN(Record) k) {
    return vec3(k.missed_r, k.missed_g, k.missed_b);
}

// Irradiance at p, n extrapolated from a record; never negative.
FN vec3 recordIrradiance(IN(Record) k, IN(vec3) p, IN(vec3) n) {
    vec3 dn = n - k.normal;
    vec3 d = p - k.position;
    return max(k.irradiance + vec3(dot(dn, k.rotation_r) + dot(d, k.translation_r),
                                   dot(dn, k.rotation_g) + dot(d, k.translation_g),
                                   dot(dn, k.rotation_b) + dot(d, k.translation_b)),
               vec3(0.0f));
}

// The same on a bump of normal m, which sees what the smooth surface of normal n sees, and nothing
// below. Of light from near n the part cos(m, n) arrives there, and more of what comes along m - n,
// as the rotation gradient tells; of light that is the same from everywhere (1 + cos(m, n)) / 2.
FN vec3 bumpIrradiance(IN(Record) k, IN(vec3) p, IN(vec3) n, IN(vec3) m) {
    vec3 dm = m - n;
    float even = 0.5f + 0.5f * dot(m, n);
    return max(even * recordIrradiance(k, p, n) + vec3(dot(dm, k.rotation_r), dot(dm, k.rotation_g),
                                                       dot(dm, k.rotation_b)),
               vec3(0.0f));
}

#endif
