// Where photons start: pieces of surfaces, chosen as likely as what starts there is worth while.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "scene/scene.h"

namespace sheen {

/// A side of a piece of a triangle.
struct Patch {
    uint32_t triangle;
    bool back;
    std::array<vec2, 3> corners;  ///< Embree's barycentric coordinates
    double likely;                ///< before anything is known: by area, albedo and number
};

class PhotonStarts {
  public:
    /// All of a scene, or those of specular surfaces.
    PhotonStarts(const Scene& scene, bool specular);

    bool empty() const { return patches_.empty(); }
    const Patch& patch(size_t i) const { return patches_[i]; }
    /// Neighbouring patches, about as many in each, are a part.
    size_t partCount() const { return part_count_; }
    size_t partOf(size_t patch) const { return parts_[patch]; }

    struct Choice {
        size_t patch;
        double probability;
    };
    /// By u in [0, 1): patches in a row, so that neighbouring u choose neighbouring ones.
    Choice choose(double u) const;

    /// From now on a part is as likely as the light [part] that photons which started there
    /// brought, and, since that is known to within chance, a little beyond.
    void heed(const std::vector<double>& light);

  private:
    void setLikelihoods(const std::vector<double>& factors);

    std::vector<Patch> patches_;
    std::vector<uint32_t> parts_;  // [patch]
    size_t part_count_ = 0;
    std::vector<double> sums_;  // [patch + 1], of likelihoods; ends in 1
};

}  // namespace sheen
