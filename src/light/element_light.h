// Light kept at elements: each finds by rays what the others send it, until nothing changes any
// more. Based on: [WRC88] for light kept where it varies little.
#pragma once

#include <span>
#include <vector>

#include "light/elements.h"
#include "light/kept_light.h"
#include "light/ways_on.h"

namespace sheen {

class ElementLight : public KeptLight {
  public:
    /// `once`: what lights do to surfaces. `bounces`: as WaysOn has them.
    ElementLight(const ScatteredOnce& once, Elements elements, int bounces);

    explicit ElementLight(ByteReader& in);

    std::optional<vec3> irradiance(const ElementSite& at, int followed) const override;
    size_t size() const override { return elements_.size(); }
    void write(ByteWriter& out) const override;

  private:
    struct Equation;
    struct Neighbours;

    Neighbours neighbours(const vec3& p, const vec3& n) const;
    Equation equationOf(const WaysOn& ways, size_t element) const;
    void solve(std::span<const Equation> equations, int bounces, int most);

    const Elements elements_;
    // [rays followed][element]: irradiance of light that is scattered less often by so much.
    std::vector<std::vector<vec3>> kept_;
};

}  // namespace sheen
