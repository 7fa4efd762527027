// Views (shaders/shared/view.glsl) and how to make them.
#pragma once

#include "core/math.h"
#include "scene/scene.h"

namespace sheen::shared {
using namespace glm;
#include "shared/view.glsl"
}  // namespace sheen::shared

namespace sheen {

using shared::View;
static_assert(sizeof(View) == 7 * 16, "View is uploaded as a std430 array");

/// A perspective view from `origin`; right, up and forward as in view.glsl, world space.
View perspectiveView(const vec3& origin, const vec3& right, const vec3& up, const vec3& forward,
                     float near);
/// A parallel view of the box origin + [-1,1] right + [-1,1] up + [0,1] forward.
View parallelView(const vec3& origin, const vec3& right, const vec3& up, const vec3& forward);
/// The view of an image's pixels: (u, v) = (-1, -1) is the *top left* corner, so that row 0 of what
/// OpenGL draws is row 0 of the image. Without a near plane: rays see what it shows.
View cameraView(const Camera& camera, int width, int height);

/// Whether a sphere may be seen in a view (conservative). A parallel view is taken as endless.
bool sphereInView(const View& view, const vec3& center, float radius);

}  // namespace sheen
