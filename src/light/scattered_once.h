// Light scattered once: what lights, lamps and the sky send by way of the surface a ray meets, and
// the sky where it meets none.
#pragma once

#include <optional>

#include "light/irradiance_cells.h"
#include "light/light_cells.h"
#include "light/outgoing.h"
#include "light/scene_lights.h"
#include "light/sky.h"
#include "rays/surface_point.h"

namespace sheen {

class ScatteredOnce : public OutgoingLight {
  public:
    /// Every hit is lit by itself. `lights`, where given, must outlive this: rays see lamps black,
    /// since their light is direct light of what rays leave, and hits are lit by them. Where not,
    /// what emits is seen and lights nothing, and punctual lights are asked one by one.
    explicit ScatteredOnce(const Tracer& tracer, const SceneLights* lights = nullptr)
        : OutgoingLight(tracer), lights_(lights), sky_(tracer.scene().environment) {}
    /// Cells are taken for the light on pieces of surface smaller than what a ray stands for.
    /// `near`, `cell_length`: as LightCells has them.
    ScatteredOnce(const Tracer& tracer, const SceneLights* lights, const std::vector<Bounds>& near,
                  float cell_length = LightCells::kLength);

    void radiance(const Rays& rays, std::span<const Hit> hits, vec3* radiance) const override;

  private:
    static constexpr uint32_t kCellSamples = 8;
    struct Lit;
    struct Asked;
    void addPunctual(const Rays& rays, std::span<const Lit> lacking, vec3* radiance) const;
    // What is asked one by one.
    std::span<const PunctualLight> each() const {
        return lights_ != nullptr ? lights_->punctual.each() : scene().lights;
    }
    // Whether there is more.
    bool choosing() const {
        return skyLights() ||
               (lights_ != nullptr && !(lights_->lamps.empty() && lights_->punctual.empty()));
    }
    // Whether the sky does more than to be seen.
    bool skyLights() const { return !sky_.empty() && !scene().lightmapped; }
    bool lambertian(const Hit& hit) const {
        return isLambertian(scene().materials[scene().materials_of[hit.triangle]]);
    }
    void sample(std::span<const Asked> points, vec3* radiance) const;
    Asked pointAt(const Hit& hit, const vec2& uv, const vec3& wo) const;
    vec3 scatteredByCell(const Hit& hit, const IrradianceCells::Cell& cell) const;
    void addSampled(const Rays& rays, std::span<const Lit> lit, vec3* radiance) const;

    const SceneLights* lights_;
    SkySampler sky_;
    std::optional<LightCells> cells_;
    std::optional<IrradianceCells> sampled_;  // by what is asked by chance
};

}  // namespace sheen
