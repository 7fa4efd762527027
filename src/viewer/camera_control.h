// A camera that a hand moves: it turns about a point, or flies.
#pragma once

#include "scene/scene.h"

namespace sheen {

class CameraControl {
  public:
    /// Begins as `start`, upright, and turns about what it looks at: a point as far off as the
    /// middle of the bounds, or, where these are behind, the scene's size.
    CameraControl(const Camera& start, const Bounds& bounds);

    /// Upright: its right axis is level.
    Camera camera() const;
    const vec3& eye() const { return eye_; }
    vec3 target() const { return eye_ + distance_ * forward(); }
    float yFov() const { return start_.y_fov; }
    /// The scene's size, by which steps are measured.
    float scale() const { return scale_; }

    /// About the target: radians to the right and up.
    void orbit(float right, float up);
    /// About the eye.
    void turn(float right, float up);
    /// Along the image's axes and into it, scene units; the target comes along.
    void move(const vec3& right_up_forward);
    /// Toward the target: the distance is multiplied by this.
    void approach(float factor);
    void setYFov(float radians) { start_.y_fov = radians; }

  private:
    vec3 forward() const;
    vec3 right() const;
    void look(float right, float up);

    Camera start_;
    float scale_;
    vec3 eye_;
    float yaw_, pitch_;  // radians: of -z about +y, and above the horizon
    float distance_;     // of the target
};

}  // namespace sheen
