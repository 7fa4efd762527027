// Closed forms for texels of a plane at distance 1 along z, (x, y) in the plane.
#ifndef SHARED_HEMISPHERE_GLSL
#define SHARED_HEMISPHERE_GLSL

#include "shared/language.glsl"

// Solid angle between the origin's quadrant corner and (x, y).
FN float planeSolidAngleCorner(float x, float y) {
    return atan(x * y / sqrt(1.0f + x * x + y * y));
}

// Solid angle of the rectangle [x0, x1] x [y0, y1] seen from distance 1.
FN float planeSolidAngle(float x0, float y0, float x1, float y1) {
    return planeSolidAngleCorner(x1, y1) - planeSolidAngleCorner(x0, y1) -
           planeSolidAngleCorner(x1, y0) + planeSolidAngleCorner(x0, y0);
}

// Integral of cos(theta) over the solid angle of the same corner: the point-to-rectangle form
// factor times pi.
FN float planeCosineCorner(float x, float y) {
    float rx = 1.0f / sqrt(1.0f + x * x);
    float ry = 1.0f / sqrt(1.0f + y * y);
    return 0.5f * (x * rx * atan(y * rx) + y * ry * atan(x * ry));
}

FN float planeCosine(float x0, float y0, float x1, float y1) {
    return planeCosineCorner(x1, y1) - planeCosineCorner(x0, y1) - planeCosineCorner(x1, y0) +
           planeCosineCorner(x0, y0);
}

// Cosine of the polar angle at which a plane of half-extent h ends, at azimuth phi. The strip from
// there to the horizon is what border texels stretch over: its solid angle is the integral of this
// over phi, its cosine integral half that of the square. (The omega_border of [KGWAJ07], which
// [GKB09, 8.4.1] describes in words, is a solid angle and must not be multiplied by the texel's
// cosine.)
FN float borderCosine(float phi, float h) {
    float r = h / max(abs(cos(phi)), abs(sin(phi)));
    return 1.0f / sqrt(1.0f + r * r);
}

#endif
