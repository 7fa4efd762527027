// Light that specular surfaces alone send from lights, lamps and the sky to surfaces that are not
// specular: photons that start where lights reach specular surfaces, and follow their lobes.
// Based on: [Jen96], with photons aimed by what a first part of them found [PP98].
#pragma once

#include <vector>

#include "light/photon_map.h"
#include "light/scene_lights.h"

namespace sheen {

/// The space around points whose light is wanted, in cells.
class SeenSpace {
  public:
    SeenSpace() = default;
    /// That of points and of what lies within a cell of them.
    explicit SeenSpace(const std::vector<vec3>& points);

    bool empty() const { return filled_.empty(); }
    /// Of a cell: nothing farther off counts for a point.
    float reach() const { return size_; }
    bool contains(const vec3& p) const;

  private:
    static constexpr int kCells = 16;  // along the longest side

    ivec3 cellOf(const vec3& p) const;

    vec3 lower_{0.0f};
    float size_ = 0.0f;
    ivec3 counts_{0};
    std::vector<uint8_t> filled_;  // [z][y][x]
};

/// `count` photons that leave lights and meet specular surfaces, from 1 to `bounces` of them; those
/// that then lie in `seen` on a surface that is not, or not only, specular. The same for any number
/// of threads. None where nothing is specular or nothing shines.
std::vector<Photon> traceCaustics(const Tracer& tracer, const SceneLights& lights,
                                  const SeenSpace& seen, int count, int bounces);

}  // namespace sheen
