// Pixels that an edge passes through, looked at more closely: what samples of theirs see, whose
// light they take, and points that no pixel's middle sees.
#pragma once

#include <vector>

#include "light/scene_lights.h"
#include "receivers/receivers.h"

namespace sheen {

/// What samples of a pixel that see one surface make of the light that arrives there: sums of their
/// reflectances over the number of all samples.
struct EdgeShare {
    int receiver = 0;  ///< whose light it is: a pixel's, or from Edges::strays' first on a stray's
    vec3 diffuse{0.0f};
    vec3 specular{0.0f};  ///< albedo of the lobe
};

/// A triangle that samples of a pixel see, and how many of them.
struct EdgeTriangle {
    uint32_t triangle = 0;
    float coverage = 0;
};

/// Means over the samples of one pixel.
struct EdgePixel {
    size_t pixel = 0;
    float coverage = 0;  ///< of them, see a surface, or of the light that panes before nothing stop
    vec3 direct{0.0f};
    vec3 emission{0.0f};
    size_t first_share = 0;  ///< of its shares, up to the next pixel's
    size_t first_seen = 0;   ///< of its triangles, likewise
};

struct Edges {
    std::vector<EdgePixel> pixels;
    std::vector<EdgeShare> shares;
    std::vector<EdgeTriangle> seen;
    /// Points that samples see and no pixel around, as receivers in a column of their own: thin or
    /// small things. They come after the pixels, whose number is `first_stray`.
    Receivers strays;
    int first_stray = 0;

    /// The end of the shares of the k-th pixel.
    size_t endOfShares(size_t k) const {
        return k + 1 < pixels.size() ? pixels[k + 1].first_share : shares.size();
    }
    /// Likewise of its triangles.
    size_t endOfSeen(size_t k) const {
        return k + 1 < pixels.size() ? pixels[k + 1].first_seen : seen.size();
    }
};

/// Samples of one pixel, as many as `count`, a power of two: of that many rows and of that many
/// columns each holds one, so that edges along the axes have as many steps. In [0, 1)^2; the middle
/// for one. The Hammersley points.
std::vector<vec2> pixelSamples(int count);

/// Which of the surfaces on the way of a camera's rays pixels show, as renderGBuffer() has it, and
/// its share of each pixel's light (empty: all of it).
struct Veil {
    int number = 0;
    const Image<vec3>& share;
};

/// Looks through `count` samples at each pixel whose corners see another surface or reflectance
/// than its middle, or whose own light differs from its neighbours', and at those beside them into
/// which what samples see may reach. `pixels`: what the camera sees, with direct light by rays.
/// Samples get direct light of their own; other light they take from the most alike of the pixels
/// here and around that see their surface, and of all that their own share. `sh_order`: as
/// receiversOf() has it. Environment error likewise.
Edges findEdges(const Tracer& tracer, const SceneLights& lights, const Camera& camera,
                const Receivers& pixels, const Veil& veil, int sh_order, int count);

}  // namespace sheen
