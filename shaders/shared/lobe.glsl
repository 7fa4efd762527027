// How the specular lobes of pixels are stored, and in which groups of coefficients they are
// splatted.
#ifndef SHARED_LOBE_GLSL
#define SHARED_LOBE_GLSL

#include "shared/language.glsl"

// Coefficients are whole numbers up to this, which the greatest of a pixel has: two in an int.
const int LOBE_STEPS = 32767;
// The first group goes with the gradients, and more would not fit into what a quad may carry. The
// size of the others wastes least over the orders (docs/decisions/raster.md).
const int LOBE_FIRST_GROUP = 16;
const int LOBE_NEXT_GROUP = 24;

// Groups that the coefficients of an order fill, the last one with zeros to its end.
FN int lobeGroups(int order) {
    return 1 + max(order * order - LOBE_FIRST_GROUP + LOBE_NEXT_GROUP - 1, 0) / LOBE_NEXT_GROUP;
}

// Where a group begins, and where the one before it ends.
FN int lobeGroupFirst(int group) {
    return group == 0 ? 0 : LOBE_FIRST_GROUP + (group - 1) * LOBE_NEXT_GROUP;
}

#endif
