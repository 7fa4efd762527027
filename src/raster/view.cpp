#include "raster/view.h"

#include <algorithm>
#include <cmath>
#include <iterator>

namespace sheen {
namespace {

View makeView(const vec3& origin, const vec3& right, const vec3& up, const vec3& forward) {
    const mat3 dual = glm::transpose(glm::inverse(mat3(right, up, forward)));
    View view{};
    view.origin = origin;
    view.right = right;
    view.up = up;
    view.forward = forward;
    view.dual_right = dual[0];
    view.dual_up = dual[1];
    view.dual_forward = dual[2];
    return view;
}

}  // namespace

View perspectiveView(const vec3& origin, const vec3& right, const vec3& up, const vec3& forward,
                     float near) {
    View view = makeView(origin, right, up, forward);
    view.kind = shared::VIEW_PERSPECTIVE;
    view.near = near;
    return view;
}

View parallelView(const vec3& origin, const vec3& right, const vec3& up, const vec3& forward) {
    View view = makeView(origin, right, up, forward);
    view.kind = shared::VIEW_PARALLEL;
    return view;
}

View cameraView(const Camera& camera, int width, int height) {
    const ivec2 whole = camera.wholeSize({width, height});
    const float tan_half = std::tan(0.5f * camera.y_fov);
    const float aspect = static_cast<float>(whole.x) / static_cast<float>(whole.y);
    const mat3 axes(camera.world_from_camera);
    const vec3 right = axes[0] * tan_half * aspect;
    const vec3 down = -axes[1] * tan_half;
    // Of a part: as large as it is of the whole, about its own middle.
    const vec2 share = vec2(width, height) / vec2(whole);
    const vec2 middle =
        (2.0f * vec2(camera.window.first) + vec2(width, height)) / vec2(whole) - 1.0f;
    const vec3 forward =
        camera.window.whole.x > 0 ? -axes[2] + middle.x * right + middle.y * down : -axes[2];
    return perspectiveView(vec3(camera.world_from_camera[3]), share.x * right, share.y * down,
                           forward, 0.0f);
}

PixelGrid pixelGrid(const Camera& camera, int width, int height) {
    const int whole_height = camera.wholeSize({width, height}).y;
    return {.width = width,
            .height = height,
            .whole_height = whole_height,
            .view = cameraView(camera, width, height),
            .pixel_angle = 2.0f * std::tan(0.5f * camera.y_fov) / static_cast<float>(whole_height)};
}

bool sphereInView(const View& view, const vec3& center, float radius) {
    const vec3 d = center - view.origin;
    if (view.kind == shared::VIEW_PARALLEL) {
        const vec3 duals[] = {view.dual_right, view.dual_up};
        return std::all_of(std::begin(duals), std::end(duals), [&](const vec3& dual) {
            return std::abs(glm::dot(dual, d)) <= 1.0f + radius * glm::length(dual);
        });
    }
    const vec3 planes[] = {view.dual_forward, view.dual_forward + view.dual_right,
                           view.dual_forward - view.dual_right, view.dual_forward + view.dual_up,
                           view.dual_forward - view.dual_up};
    for (const vec3& plane : planes) {
        if (glm::dot(plane, d) < -radius * glm::length(plane)) {
            return false;
        }
    }
    return true;
}

}  // namespace sheen
