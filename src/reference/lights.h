// Lights with an extent, as a path tracer samples them: lamps, which are the triangles that emit,
// and the sky. A direction toward each can be chosen by chance, and it is known how likely any
// direction was to be chosen, so that it can be weighed against directions chosen by the BRDF.
// Based on: [VG95] for the weights, [PJH23, 12.5] for the sky.
#pragma once

#include <vector>

#include "reference/ray_scene.h"

namespace sheen {

/// The way toward a light, and what shines there if nothing lies between.
struct LightChoice {
    ShadowRay way;        ///< of distance 0 where there is nothing to choose
    vec3 radiance{0.0f};  ///< nits
    float pdf = 0.0f;     ///< per solid angle
};

/// All triangles that emit, chosen by their power. Both their sides shine.
class Lamps {
  public:
    /// The scene must outlive it.
    explicit Lamps(const Scene& scene);

    bool empty() const { return triangles_.empty(); }
    /// A point of a lamp; u in [0, 1)^2, whose strata become strata of their surface.
    LightChoice choose(const vec3& from, const vec2& u) const;
    bool contains(uint32_t triangle) const { return !empty() && densities_[triangle] > 0.0f; }
    /// Of choosing the point of `s`, which lies on `triangle`, seen from `from`; 0 for no lamp's.
    float pdf(uint32_t triangle, const Surface& s, const vec3& from) const;

  private:
    const Scene& scene_;
    std::vector<uint32_t> triangles_;
    std::vector<double> shares_;    // [lamp + 1], cumulative, of the power
    std::vector<float> densities_;  // [triangle of the scene], of a point, per area; or empty
};

/// The scene's environment, chosen by its radiance.
class Sky {
  public:
    /// The environment must outlive it.
    explicit Sky(const Environment& environment);

    bool empty() const { return total_ == 0.0; }
    LightChoice choose(const vec3& from, const vec2& u) const;
    float pdf(const vec3& wi) const;
    vec3 radiance(const vec3& wi) const { return environment_.radiance(wi); }

  private:
    float pdfOf(int x, int y) const;

    const Environment& environment_;
    double total_ = 0.0;
    std::vector<double> rows_;     // [row + 1], cumulative, ends in 1
    std::vector<float> columns_;   // [row][column + 1], cumulative within a row, ends in 1
    std::vector<double> cosines_;  // [row + 1], of the polar angle at its edges
};

struct Lights {
    Lamps lamps;
    Sky sky;

    explicit Lights(const Scene& scene) : lamps(scene), sky(scene.environment) {}
    bool empty() const { return lamps.empty() && sky.empty(); }
};

/// Of the sample that `own` chose, where `other` could have chosen it too: the balance heuristic.
inline float balance(float own, float other) { return own > 0.0f ? own / (own + other) : 0.0f; }

}  // namespace sheen
