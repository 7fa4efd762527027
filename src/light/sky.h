// The light of the surroundings, sampled at the points that rays meet.
#pragma once

#include <vector>

#include "scene/environment.h"

namespace sheen {

/// Safe to use from many threads. The environment must outlive it.
class SkySampler {
  public:
    explicit SkySampler(const Environment& environment);

    bool empty() const { return environment_.empty(); }
    /// From a unit direction, nits.
    vec3 radiance(const vec3& direction) const { return environment_.radiance(direction); }

    struct Sample {
        vec3 wi;  ///< unit
        vec3 radiance;
        float density;  ///< over solid angle; 0: no light comes by these numbers
    };
    /// By u in [0, 1)^2: a sky of one colour by the cosine to the unit normal n, an image by its
    /// brightness.
    Sample sample(const vec3& n, const vec2& u) const;

  private:
    const Environment& environment_;
    // Of an image: cells of latitude and longitude, and the sum of their light up to each.
    int width_ = 0, height_ = 0;
    std::vector<float> rows_;   // [height_ + 1]
    std::vector<float> cells_;  // [height_][width_ + 1]
};

}  // namespace sheen
