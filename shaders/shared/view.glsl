// A view: a perspective (or, for directional lights, parallel) projection onto a rectangle. The
// camera, the faces of a record's hemisphere and the shadow maps are all views.
// A point of the rectangle has coordinates (u, v) in [-1, 1]^2; the direction toward it is
//   forward + u right + v up,
// where the three need not be orthogonal (a half face of a hemicube leans its forward axis).
#ifndef SHARED_VIEW_GLSL
#define SHARED_VIEW_GLSL

#include "shared/language.glsl"

const int VIEW_PERSPECTIVE = 0;
const int VIEW_PARALLEL = 1;

struct View {
    vec3 origin;
    float near;       // distance along forward of the near plane; parallel: unused
    vec3 right;
    int kind;
    vec3 up;
    float texel_size; // of a shadow map texel: relative to the distance, or absolute if parallel
    vec3 forward;
    int coarser;      // of a directional light: the view for what this one does not hold; 0: none
    vec3 dual_right;  // rows of the inverse of the matrix (right, up, forward)
    float pad1;
    vec3 dual_up;
    float pad2;
    vec3 dual_forward;
    float pad3;
};

// Not normalised; perspective views only.
FN vec3 viewDirection(IN(View) view, IN(vec2) uv) {
    return view.forward + uv.x * view.right + uv.y * view.up;
}

// Coordinates along (right, up, forward) of a world-space point.
FN vec3 viewCoordinates(IN(View) view, IN(vec3) p) {
    vec3 d = p - view.origin;
    return vec3(dot(view.dual_right, d), dot(view.dual_up, d), dot(view.dual_forward, d));
}

// Clip coordinates with reversed depth: 1 at the near plane, 0 at infinity (or at the end of a
// parallel view's box). An infinite far plane and float depth keep the relative precision constant.
FN vec4 clipFromWorld(IN(View) view, IN(vec3) p) {
    vec3 c = viewCoordinates(view, p);
    if (view.kind == VIEW_PARALLEL) {
        return vec4(c.x, c.y, 1.0f - c.z, 1.0f);
    }
    return vec4(c.x, c.y, view.near, c.z);
}

#endif
