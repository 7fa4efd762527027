// Rays that see light: what a ray meets first, lit by the punctual lights. The reference has rays
// of its own (reference/ray_scene.h): were they these, a mistake here would go unseen by what
// judges it. Based on: [WWB14].
#pragma once

#include <embree3/rtcore.h>

#include <memory>
#include <span>

#include "scene/scene.h"

namespace sheen {

/// Casts rays into a scene, which must outlive it. Safe to use from many threads.
class RayCaster {
  public:
    /// Environment error where Embree cannot start or runs out of memory.
    explicit RayCaster(const Scene& scene);

    /// Rays that are cast together; more are cast in several packets.
    static constexpr int kPacket = 8;

    /// For each of `directions` (unit), from `origin`: the radiance that arrives, light scattered
    /// once and emission, and in w the distance it comes from; all zero where nothing is met. As
    /// many `seen` as directions. Neighbouring rays should point in similar directions.
    /// `solid_angles`, as many: of the cone a ray stands for. Highlights narrower than it are seen
    /// as wide as it is (filteredAlpha() in brdf.glsl); null: each ray stands for itself.
    void cast(const vec3& origin, std::span<const vec3> directions, vec4* seen,
              const float* solid_angles = nullptr) const;

    /// Where a ray starts that leaves a point of a surface, whose geometric normal n_g is on the
    /// side of the unit direction `toward_viewer`, from where the point is seen (zero: from
    /// nowhere). The step toward the viewer keeps the start on the viewer's side of a second
    /// surface that touches the first one here.
    vec3 origin(const vec3& position, const vec3& n_g, const vec3& toward_viewer) const {
        return position + offset_ * (n_g + toward_viewer);
    }

  private:
    struct ReleaseDevice {
        void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
    };
    struct ReleaseScene {
        void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
    };
    void build();
    void castPacket(const vec3& origin, std::span<const vec3> directions, vec4* seen,
                    const float* solid_angles) const;

    const Scene& scene_;
    float offset_ = 0;
    std::unique_ptr<RTCDeviceTy, ReleaseDevice> device_;
    std::unique_ptr<RTCSceneTy, ReleaseScene> embree_;
};

}  // namespace sheen
