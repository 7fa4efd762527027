// Rays that see light: what a ray meets first, lit by the punctual lights. The reference has rays
// of its own (reference/ray_scene.h): were they these, a mistake here would go unseen by what
// judges it. Based on: [WWB14].
#pragma once

#include <embree3/rtcore.h>

#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "scene/scene.h"

namespace sheen {

class LightCells;

/// Rays from one point. Neighbours should point in similar directions.
struct Rays {
    vec3 origin;
    std::span<const vec3> directions;  ///< unit
    /// Of the cone a ray stands for, as many as directions. Highlights narrower than it are seen as
    /// wide as it is (filteredAlpha() in brdf.glsl). None: each ray stands for itself.
    std::span<const float> solid_angles = {};

    float solidAngle(size_t i) const { return solid_angles.empty() ? 0.0f : solid_angles[i]; }
};

/// Casts rays into a scene, which must outlive it. Safe to use from many threads.
class RayCaster {
  public:
    /// Environment error where Embree cannot start or runs out of memory.
    explicit RayCaster(const Scene& scene);

    const Scene& scene() const { return scene_; }

    /// Rays that meet the scene together.
    static constexpr int kPacket = 8;

    /// For each ray: the radiance that arrives, light scattered once and emission, and in w the
    /// distance it comes from; all zero where nothing is met. As many `seen` as rays. `cells`,
    /// where given, are taken for the light on pieces of surface smaller than what a ray stands
    /// for. `planes`, where given, get those of the triangles met: along a unit direction d from
    /// the origin, a plane lies at distance 1 / dot(plane, d); zero where nothing is met.
    void cast(const Rays& rays, vec4* seen, const LightCells* cells = nullptr,
              vec3* planes = nullptr) const;

    /// What a ray meets first: a triangle, and there the barycentric coordinates of its second and
    /// third vertex.
    struct FirstHit {
        uint32_t triangle = 0;
        float u = 0, v = 0;
        float distance = 0;
    };
    /// None where nothing is met. The ray is cast alone: which of two triangles owns a ray through
    /// their common edge differs by how many are cast together.
    std::optional<FirstHit> meetFirst(const vec3& origin, const vec3& direction) const;

    /// A point of a surface that may be lit: from where its rays start see offSurface().
    struct Receiver {
        vec3 position, n_g, toward_viewer;
        float offset;
    };
    /// Which of at most kPacket receivers get light from `light` on the side of n_g: bit k is the
    /// k-th one's.
    uint32_t reached(const PunctualLight& light, std::span<const Receiver> receivers) const;

  private:
    struct ReleaseDevice {
        void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
    };
    struct ReleaseScene {
        void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
    };
    void build();
    struct Hit;
    size_t meet(const Rays& rays, size_t first, size_t end, const LightCells* cells, vec4* seen,
                vec3* planes, Hit* hits) const;
    void light(const Rays& rays, std::span<const Hit> hits, vec4* seen) const;

    const Scene& scene_;
    std::unique_ptr<RTCDeviceTy, ReleaseDevice> device_;
    std::unique_ptr<RTCSceneTy, ReleaseScene> embree_;
};

}  // namespace sheen
