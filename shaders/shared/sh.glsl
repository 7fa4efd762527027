// Real spherical harmonics, orthonormal over the sphere, without the Condon-Shortley phase:
// coefficient l(l+1)+m; Y_1,-1 ~ y, Y_1,0 ~ z, Y_1,1 ~ x.
// Based on: [Slo13], with recurrences normalised as in [Hob55].
#ifndef SHARED_SH_GLSL
#define SHARED_SH_GLSL

#include "shared/language.glsl"

const int SH_MAX_ORDER = 10;
const int SH_MAX_COEFFICIENTS = 100;

struct ShVector {
    float c[SH_MAX_COEFFICIENTS];
};

FN int shIndex(int l, int m) {
    return l * (l + 1) + m;
}

// What the recurrence below multiplies with; the same for every direction.
// N_lm = a (z N_{l-1,m} - b N_{l-2,m}), and N_mm where that begins.
struct ShFactors {
    float diagonal[SH_MAX_ORDER];   // [m]: N_mm
    float a[SH_MAX_COEFFICIENTS];   // [shIndex(l, m)], l > m >= 0
    float b[SH_MAX_COEFFICIENTS];
};

FN ShFactors shFactors() {
    ShFactors factors;
    float diagonal = sqrt(0.25f / PI);
    for (int m = 0; m < SH_MAX_ORDER; ++m) {
        if (m > 0) {
            diagonal = diagonal * sqrt((2.0f * float(m) + 1.0f) / (2.0f * float(m)));
        }
        factors.diagonal[m] = diagonal;
        for (int l = m + 1; l < SH_MAX_ORDER; ++l) {
            float ll = float(l * l);
            float mm = float(m * m);
            float kk = float((l - 1) * (l - 1));
            factors.a[shIndex(l, m)] = sqrt((4.0f * ll - 1.0f) / (ll - mm));
            factors.b[shIndex(l, m)] = sqrt((kk - mm) / (4.0f * kk - 1.0f));
        }
    }
    return factors;
}

// The basis at a unit direction, bands 0..order-1; the rest of the vector is not written.
// Y_lm = N_lm(z) Re/Im (x + iy)^|m|: the power carries sin^|m|(theta), so nothing divides by it.
FN ShVector shBasis(IN(vec3) d, int order, IN(ShFactors) factors) {
    ShVector y;
    float re = 1.0f;  // (x + iy)^m
    float im = 0.0f;
    for (int m = 0; m < order; ++m) {
        if (m > 0) {
            float next_re = d.x * re - d.y * im;
            im = d.x * im + d.y * re;
            re = next_re;
        }
        float scale = m > 0 ? sqrt(2.0f) : 1.0f;
        float below = 0.0f;  // N_{l-2,m}
        float current = factors.diagonal[m];
        for (int l = m; l < order; ++l) {
            if (l > m) {
                float next = factors.a[shIndex(l, m)] *
                             (d.z * current - factors.b[shIndex(l, m)] * below);
                below = current;
                current = next;
            }
            y.c[shIndex(l, m)] = scale * current * re;
            if (m > 0) {
                y.c[shIndex(l, -m)] = scale * current * im;
            }
        }
    }
    return y;
}

#endif
