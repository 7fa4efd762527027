// The ways on from what rays meet: where light came from that surfaces there reflect.
#pragma once

#include <functional>
#include <optional>
#include <span>

#include "light/elements.h"
#include "light/scattered_once.h"

namespace sheen {

/// Safe to use from many threads.
class WaysOn {
  public:
    /// `once` must outlive this. `bounces`: so often light is scattered on its way to where it is
    /// looked for, at least twice.
    WaysOn(const ScatteredOnce& once, int bounces) : once_(once), bounces_(bounces) {}

    const ScatteredOnce& once() const { return once_; }
    const Tracer& tracer() const { return once_.tracer(); }
    const Scene& scene() const { return once_.scene(); }
    int bounces() const { return bounces_; }
    /// A way goes on from so many surfaces at the most. The lobe of the last counts as if diffuse.
    static constexpr int kMost = 8;
    int most() const;

    /// What a ray meets, and what scatters light there.
    struct Point {
        struct Glossy {
            SurfacePoint p;
            Scatterer surface;
            vec3 specular_albedo;
        };
        const Hit& hit;
        vec3 wo;
        std::optional<Glossy> glossy;  ///< none: Lambertian

        Point(const Scene& scene, const Hit& hit, const vec3& wo);
        /// Of a Lambertian surface, at barycentric coordinates uv of its triangle.
        vec3 albedoAt(const Scene& scene, const vec2& uv) const;
        vec3 albedo(const Scene& scene) const;
        ElementSite site(const Scene& scene) const;
    };

    /// What lights do to a surface after the first ones, toward a ray.
    using Light = std::function<void(size_t ray, int followed, const vec3& radiance)>;
    /// Asks what is kept at a surface, the first ones among them: by `weight` arrives what it
    /// reflects diffusely of the irradiance there, and what it would by `lobe`, an albedo that is
    /// to count as if diffuse. False: nothing is kept, and the way goes on.
    using Ask = std::function<bool(size_t ray, int followed, const Point& point, const vec3& weight,
                                   const vec3& lobe)>;
    /// Goes on from what at most OutgoingLight::kTogether rays meet, along lobes and, where nothing
    /// is kept, by the cosine. `followed`: so many rays led from the first surface to this one.
    void follow(const Rays& rays, std::span<const Hit> hits, const Light& light,
                const Ask& ask) const;

  private:
    const ScatteredOnce& once_;
    const int bounces_;
};

}  // namespace sheen
