// Rays against a scene's triangles: Embree [WWB14], robust mode, and ray origins kept off the
// surface they leave.
#pragma once

#include <embree3/rtcore.h>

#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "image/frame.h"
#include "reference/sampling.h"
#include "scene/scene.h"

namespace sheen {

/// What a ray meets first; barycentric coordinates of the triangle's second and third vertex.
struct RayHit {
    uint32_t triangle = kNoPrimitive;
    float u = 0.0f;
    float v = 0.0f;
    /// What light that comes from there counts, be it the sky's: the ray met things by chance.
    vec3 weight{1.0f};

    bool found() const { return triangle != kNoPrimitive; }
};

/// A point of a surface as seen from direction wo: geometry and material, by the conventions all
/// stages share (two-sided).
struct Surface {
    vec3 position{0.0f};  ///< world space
    vec3 n_g{0.0f};       ///< geometric normal, unit, on the side of wo
    vec3 n{0.0f};         ///< shading normal, unit
    vec3 wo{0.0f};        ///< unit, away from the surface
    Brdf brdf;
    std::optional<Coat> coat;
    vec3 specular_albedo{0.0f};  ///< directional albedo of the specular lobe toward wo, the
                                 ///< coat left out
    vec3 emission{0.0f};         ///< nits
    float roughness = 0.0f;      ///< perceptual
    float offset = 0.0f;         ///< how far from the surface its rays start, scene units

    /// Where a ray starts that leaves the surface on the side of wo.
    vec3 rayOrigin() const { return position + offset * n_g; }
};

/// Of the random numbers by which a camera's ray chooses microfacets of rough glass.
struct Facets {
    uint32_t index;
    uint32_t seed;
};

/// A part of what a camera's ray sees.
struct Seen {
    RayHit hit;
    vec3 direction{0.0f};  ///< of the ray there, unit: glass may have bent it
    float leaving = 0.0f;  ///< as RayScene::surfaceAt() has it
    vec3 share{1.0f};      ///< of the light that leaves it, what reaches the eye
    float chance = 1.0f;   ///< that a ray which meets one of the parts by chance meets this one
};

/// The way from a surface to a light: t in [0, distance), direction unit.
struct ShadowRay {
    vec3 origin{0.0f};
    vec3 direction{0.0f};
    float distance = 0.0f;
};

/// The scene's acceleration structure. The scene must outlive it. Safe to use from many threads.
class RayScene {
  public:
    /// Environment error where Embree cannot start or runs out of memory.
    explicit RayScene(const Scene& scene);

    /// The closest hit of origin + t * direction, t >= 0. Blended surfaces and
    /// glass are hit by Crossing::chance.
    RayHit intersect(const vec3& origin, const vec3& direction) const;
    /// What a camera's ray sees, from the eye on: it does not see the backs of single-sided
    /// materials, and through blended surfaces. The last may be a miss. Bodies of glass bend it by
    /// Snell's law, and rough glass spreads it where there are `facets`.
    std::vector<Seen> see(const vec3& origin, const vec3& direction,
                          const std::optional<Facets>& facets = {}) const;
    /// What share of the light passes on the way.
    vec3 passing(const ShadowRay& ray) const;

    /// At most this many rays that start near each other and point in similar directions are
    /// cheaper together.
    static constexpr int kPacket = 8;
    /// As above, for each of `directions`; as many `hits`.
    void intersect(const vec3& origin, std::span<const vec3> directions, RayHit* hits) const;
    /// As above, for each of `rays`; those of distance 0 are not cast, and all passes. As many
    /// `shares`.
    void passing(std::span<const ShadowRay> rays, vec3* shares) const;
    /// What an image's middle of a pixel stands for: all of the pixel.
    struct PixelOf {
        const Camera& camera;
        int height;  ///< rows of the image
    };
    /// The surface at a hit of a ray of direction -wo; textures at the point alone or, for a
    /// `pixel`, averaged over what it shows. `leaving`: of a body of glass that the ray leaves
    /// there, the cosine outside.
    Surface surfaceAt(const RayHit& hit, const vec3& wo, const PixelOf* pixel = nullptr,
                      float leaving = 0.0f) const;

    const Scene& scene() const { return scene_; }

  private:
    struct ReleaseDevice {
        void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
    };
    struct ReleaseScene {
        void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
    };
    void build();
    RTCRayHit closest(const vec3& origin, const vec3& direction, float from, float to) const;
    Crossing crossing(const RayHit& hit, const vec3& direction) const;
    struct Turn;
    Turn turnAt(const RayHit& hit, const vec3& along, const std::optional<Facets>& facets) const;
    const vec3& absorptionOf(const RayHit& hit) const {
        return scene_.materials[scene_.materials_of[hit.triangle]].absorption;
    }
    bool fromBehind(const RayHit& hit, const vec3& direction) const {
        return glm::dot(n_g_[hit.triangle], direction) >= 0.0f;
    }

    const Scene& scene_;
    bool blended_ = false;   ///< some material is
    std::vector<vec3> n_g_;  ///< [triangle], unit, by winding
    std::unique_ptr<RTCDeviceTy, ReleaseDevice> device_;
    std::unique_ptr<RTCSceneTy, ReleaseScene> embree_;
};

}  // namespace sheen
