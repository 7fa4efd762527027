#include "viewer/camera_control.h"

#include <algorithm>
#include <cmath>

namespace sheen {
namespace {

// Short of straight up, where there is no right.
constexpr float kSteepest = 1.55f;

}  // namespace

CameraControl::CameraControl(const Camera& start, const Bounds& bounds) : start_(start) {
    const float size = bounds.empty() ? 1.0f : glm::length(bounds.upper - bounds.lower);
    scale_ = size > 0.0f && std::isfinite(size) ? size : 1.0f;
    eye_ = vec3(start.world_from_camera[3]);
    const vec3 ahead = -glm::normalize(vec3(start.world_from_camera[2]));
    pitch_ = std::clamp(std::asin(std::clamp(ahead.y, -1.0f, 1.0f)), -kSteepest, kSteepest);
    // Straight up or down the image's top tells where to.
    const vec3 level = std::abs(ahead.y) < 0.999f
                           ? ahead
                           : -std::copysign(1.0f, ahead.y) * vec3(start.world_from_camera[1]);
    yaw_ = std::atan2(level.x, -level.z);
    const float middle =
        bounds.empty() ? 0.0f : glm::dot(0.5f * (bounds.lower + bounds.upper) - eye_, ahead);
    distance_ = middle > 1e-3f * scale_ ? middle : scale_;
}

vec3 CameraControl::forward() const {
    return {std::sin(yaw_) * std::cos(pitch_), std::sin(pitch_),
            -std::cos(yaw_) * std::cos(pitch_)};
}

vec3 CameraControl::right() const { return {std::cos(yaw_), 0.0f, std::sin(yaw_)}; }

Camera CameraControl::camera() const {
    Camera camera = start_;
    const vec3 ahead = forward();
    camera.world_from_camera = mat4(vec4(right(), 0.0f), vec4(glm::cross(right(), ahead), 0.0f),
                                    vec4(-ahead, 0.0f), vec4(eye_, 1.0f));
    return camera;
}

void CameraControl::look(float right, float up) {
    yaw_ = std::remainder(yaw_ + right, 2.0f * kPi);
    pitch_ = std::clamp(pitch_ + up, -kSteepest, kSteepest);
}

void CameraControl::orbit(float right, float up) {
    const vec3 about = target();
    look(-right, -up);
    eye_ = about - distance_ * forward();
}

void CameraControl::turn(float right, float up) { look(right, up); }

void CameraControl::move(const vec3& d) {
    eye_ += d.x * right() + d.y * glm::cross(right(), forward()) + d.z * forward();
}

void CameraControl::approach(float factor) {
    const vec3 about = target();
    distance_ = std::clamp(distance_ * factor, 1e-4f * scale_, 1e3f * scale_);
    eye_ = about - distance_ * forward();
}

}  // namespace sheen
