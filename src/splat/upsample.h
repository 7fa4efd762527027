// Indirect light found at few pixels, for an image of more: it changes less from pixel to pixel
// than what surfaces make of it. Based on: [KCLU07], with surfaces compared as they are.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "splat/splat.h"

namespace sheen {

/// From which pixels of a coarse image each pixel of a fine one of the same view takes its light:
/// of those around it, the ones on its own surface; where there is none, the one most like it.
class Upsampling {
  public:
    Upsampling(const Receivers& coarse, const Receivers& fine);

    /// Sums of records, as of one record. A pixel around which there are none stays without.
    SplatBuffer of(const SplatBuffer& splat) const;
    /// Of an empty image a black one.
    Image<vec3> of(const Image<vec3>& light) const;

  private:
    struct Source {
        size_t pixel = 0;
        float share = 0.0f;
    };
    using Sources = std::array<Source, 4>;
    static Sources sourcesOf(const Receivers& coarse, const Receivers& fine, int x, int y);

    int width_, height_;
    std::vector<Sources> sources_;  // [fine pixel]; shares' sum 1, or 0 where nothing is seen
};

}  // namespace sheen
