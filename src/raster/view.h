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

/// An image's pixels and what it shows.
struct PixelGrid {
    int width = 0;
    int height = 0;
    int whole_height = 0;  ///< of the image that these are all or a part of
    View view{};
    float pixel_angle = 0;  ///< width of a pixel at depth 1

    int count() const { return width * height; }
    size_t index(int x, int y) const {
        return static_cast<size_t>(y) * static_cast<size_t>(width) + static_cast<size_t>(x);
    }
    /// Along the view axis.
    float depthOf(const vec3& p) const {
        return glm::dot(vec3(view.dual_forward), p - view.origin);
    }
};
PixelGrid pixelGrid(const Camera& camera, int width, int height);

/// Whether a sphere may be seen in a view (conservative). A parallel view is taken as endless.
bool sphereInView(const View& view, const vec3& center, float radius);

}  // namespace sheen
