// Light scattered more than once: what surfaces receive from each other, and is kept, is added to
// what lights, lamps and the sky do to what a ray meets. What a lobe reflects there is found along
// one more ray, and where nothing is kept near by a few rays of the cell, or one of the point.
// Based on: [JC98, 5] for asking what is kept only where it is seen from afar.
#pragma once

#include <atomic>
#include <memory>
#include <span>
#include <vector>

#include "core/bounces.h"
#include "light/irradiance_cells.h"
#include "light/kept_light.h"
#include "light/ways_on.h"

namespace sheen {

class ScatteredAgain : public OutgoingLight {
  public:
    /// `once` must outlive this. `kept`: made of it for these bounces. `near`: as LightCells has
    /// them. `bounces`: so often light is scattered on its way to where it is looked for, at least
    /// twice.
    ScatteredAgain(const ScatteredOnce& once, std::unique_ptr<const KeptLight> kept,
                   const std::vector<Bounds>& near, int bounces);

    void radiance(const Rays& rays, std::span<const Hit> hits, vec3* radiance) const override;

    int bounces() const { return ways_.bounces(); }
    /// Near what share of these nothing is kept.
    double lackingShare(std::span<const ElementSite> sites) const;
    size_t keptCount() const { return kept_->size(); }
    void writeKept(ByteWriter& out) const { kept_->write(out); }
    /// Near what share of the points so far nothing was kept.
    double missedShare() const;

  private:
    // Where nothing is kept near, cells are gathered, or not: then ways go on from each point.
    enum class Lacking : uint8_t { kGathered, kFollowed };
    // How often something kept was asked for, and how often nothing was near.
    struct Asked {
        int64_t all = 0, missed = 0;
    };
    Asked see(const Rays& rays, std::span<const Hit> hits, vec3* radiance, Lacking lacking) const;
    vec3 gathered(const ElementSite& site, uint32_t seed) const;

    const WaysOn ways_;
    const std::unique_ptr<const KeptLight> kept_;
    IrradianceCells cells_;  // of what is kept or gathered, for light of all bounces
    mutable std::atomic<int64_t> asked_{0}, missed_{0};
};

}  // namespace sheen
