// Light that the scene's lightmaps hold, as it leaves what rays meet.
#pragma once

#include "light/scattered_once.h"

namespace sheen {

/// Of a scene that is lightmapped. What `once` finds of other lights is added to it. A lobe
/// reflects of what a lightmap holds as much as of constant light, in all directions alike.
class LightmapLight : public OutgoingLight {
  public:
    /// `once` must outlive this.
    explicit LightmapLight(const ScatteredOnce& once) : OutgoingLight(once.tracer()), once_(once) {}

    void radiance(const Rays& rays, std::span<const Hit> hits, vec3* radiance) const override;

  private:
    const ScatteredOnce& once_;
};

}  // namespace sheen
