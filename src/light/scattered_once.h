// Light scattered once: what the scene's lights send by way of the surface a ray meets, and what
// surfaces emit.
#pragma once

#include <optional>

#include "light/light_cells.h"
#include "light/outgoing.h"

namespace sheen {

class ScatteredOnce : public OutgoingLight {
  public:
    /// Every hit is lit by itself.
    explicit ScatteredOnce(const Tracer& tracer) : OutgoingLight(tracer) {}
    /// Cells, of the same scene, are taken for the light on pieces of surface smaller than what a
    /// ray stands for.
    ScatteredOnce(const Tracer& tracer, LightCells cells)
        : OutgoingLight(tracer), cells_(std::move(cells)) {}

  private:
    struct Lit;
    void radiance(const Rays& rays, std::span<const Hit> hits, vec3* radiance) const override;
    void light(const Rays& rays, std::span<const Lit> lacking, vec3* radiance) const;

    std::optional<LightCells> cells_;
};

}  // namespace sheen
