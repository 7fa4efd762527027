// Light scattered more than once: what surfaces receive from each other, kept at elements, is added
// to what lights, lamps and the sky do to what a ray meets. What a lobe reflects there, and where
// no element is near, is found along one more ray. Based on: [WRC88] for light kept where it varies
// little, [JC98, 5] for asking what is kept only where it is seen from afar.
#pragma once

#include <atomic>
#include <optional>
#include <span>
#include <vector>

#include "core/bounces.h"
#include "light/elements.h"
#include "light/irradiance_cells.h"
#include "light/scattered_once.h"

namespace sheen {

class ScatteredAgain : public OutgoingLight {
  public:
    /// `once` must outlive this. `elements`: where light is kept. `near`: as LightCells has them.
    /// `bounces`: so often light is scattered on its way to where it is looked for, at least twice.
    ScatteredAgain(const ScatteredOnce& once, Elements elements, const std::vector<Bounds>& near,
                   int bounces);

    void radiance(const Rays& rays, std::span<const Hit> hits, vec3* radiance) const override;

    int bounces() const { return bounces_; }
    /// Near what share of these no element is.
    double lackingShare(std::span<const ElementSite> sites) const;
    size_t elementCount() const { return elements_.size(); }
    /// What share of the points so far no element was near.
    double missedShare() const;

  private:
    struct Point;
    struct Equation;
    struct Neighbours;

    int mostFollowed() const;
    template <class Light, class Ask>
    void follow(const Rays& rays, std::span<const Hit> hits, const Light& light,
                const Ask& ask) const;
    Neighbours neighbours(const vec3& p, const vec3& n) const;
    Equation equationOf(size_t element) const;
    void solve(std::span<const Equation> equations);
    std::optional<vec3> irradiance(const ElementSite& at, int followed) const;

    const ScatteredOnce& once_;
    const int bounces_;
    const Elements elements_;
    // [rays followed][element]: irradiance of light that is scattered less often by so much.
    std::vector<std::vector<vec3>> kept_;
    IrradianceCells cells_;  // of kept_[0]
    mutable std::atomic<int64_t> asked_{0}, missed_{0};
};

}  // namespace sheen
