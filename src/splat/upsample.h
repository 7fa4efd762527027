// Indirect light found at few pixels, for an image of more: it changes less from pixel to pixel
// than what surfaces make of it. Based on: [KCLU07], with surfaces compared as they are.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "splat/splat.h"

namespace sheen {

/// From which pixels of a coarse image each pixel of a fine one of the same view takes its light:
/// of those around it, the ones on its own surface; where there is none, the one nearby that is
/// most like it. Both must outlive it.
class Upsampling {
  public:
    Upsampling(const Receivers& coarse, const Receivers& fine);

    struct Light {
        SplatBuffer splat;
        Image<vec3> by_rays;
    };
    /// What arrives, as compose() takes it, with the reflectances of the fine image. What has its
    /// light from another material reflects it as if it were the same from everywhere. A pixel
    /// around which no record serves any stays without. `by_rays`: empty where there are none.
    Light of(const SplatBuffer& splat, const Image<vec3>& by_rays) const;
    /// Something that is not parted into what arrives and what is reflected.
    Image<vec3> of(const Image<vec3>& light) const;

  private:
    struct Source {
        uint32_t pixel = 0;
        float share = 0.0f;
    };
    struct Sources {
        std::array<Source, 4> all{};  // shares' sum 1, or 0 where nothing is near
        bool alike = false;           // of its own material and class
    };
    struct Mean;
    bool sameClass(size_t c, size_t f) const;
    Sources sourcesOf(int x, int y) const;
    Sources nearestOf(const ivec2& corner, size_t f) const;
    Mean meanOf(const SplatBuffer& splat, const Image<vec3>& by_rays, size_t f) const;

    const Receivers& coarse_;
    const Receivers& fine_;
    std::vector<Sources> sources_;  // [fine pixel]
};

}  // namespace sheen
