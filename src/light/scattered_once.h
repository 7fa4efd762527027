// Light scattered once: what lights, lamps and the sky send by way of the surface a ray meets, and
// the sky where it meets none.
#pragma once

#include <optional>

#include "light/lamps.h"
#include "light/light_cells.h"
#include "light/outgoing.h"
#include "light/sky.h"

namespace sheen {

class ScatteredOnce : public OutgoingLight {
  public:
    /// Every hit is lit by itself. `lamps`, where given, must outlive this: rays see them black,
    /// since their light is direct light of what rays leave, and hits are lit by them. Where not,
    /// what emits is seen and lights nothing.
    explicit ScatteredOnce(const Tracer& tracer, const LampSampler* lamps = nullptr)
        : OutgoingLight(tracer), lamps_(lamps), sky_(tracer.scene().environment) {}
    /// Cells, of the same scene, are taken for the light on pieces of surface smaller than what a
    /// ray stands for.
    ScatteredOnce(const Tracer& tracer, const LampSampler* lamps, LightCells cells)
        : ScatteredOnce(tracer, lamps) {
        cells_ = std::move(cells);
    }

    void radiance(const Rays& rays, std::span<const Hit> hits, vec3* radiance) const override;

  private:
    struct Lit;
    void addPunctual(const Rays& rays, std::span<const Lit> lacking, vec3* radiance) const;
    void addSampled(const Rays& rays, std::span<const Lit> lit, vec3* radiance) const;

    const LampSampler* lamps_;
    SkySampler sky_;
    std::optional<LightCells> cells_;
};

}  // namespace sheen
