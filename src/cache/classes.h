// Which pixels pay for what: irradiance only, or spherical harmonics of how many bands.
#pragma once

#include <cstdint>
#include <vector>

#include "image/image.h"
#include "raster/gbuffer.h"

namespace sheen {

/// Order of a pixel that sees no geometry.
constexpr int kNoOrder = -1;
/// A pixel is diffuse where replacing its specular lobe by a cosine of the same albedo is predicted
/// to change it by less than this share.
constexpr float kDiffuseBudget = 0.005f;
/// A material gets the smallest order whose truncated bands are predicted to change its pixels by
/// less than this share.
constexpr float kTruncationBudget = 0.025f;
/// A pixel is too glossy for the cache where its material's order misses that by this much.
constexpr float kTooGlossy = 0.1f;
/// By this much where it lies in a square of such pixels, of 2 kTogether + 1 a side or what the
/// image's border leaves of one: these share their rays (gatherSpecular()). On a silhouette few do,
/// and noise would be worse than truncation.
constexpr float kTooGlossyTogether = 0.05f;
constexpr int kTogether = 2;

struct PixelClasses {
    Image<int> orders;       ///< per pixel: kNoOrder, shared::DIFFUSE_ORDER or bands
    Image<uint8_t> by_rays;  ///< 1: the specular light comes from rays, see gatherSpecular();
                             ///< the order is that of a diffuse pixel then
    std::vector<int> material_orders;  ///< per material of the scene
    int geometry = 0;                  ///< pixels that see geometry
    int diffuse = 0;                   ///< of these, diffuse
    int too_glossy = 0;                ///< of geometry, smoother than the order resolves
};

/// The order that `sh_order` (0: by prediction) gives a material; shared::DIFFUSE_ORDER for one
/// whose specular lobe never matters.
int materialOrder(const MaterialParams& material, int sh_order);
/// The same of a material with its texture, by so dark a texel that one in twenty is darker: the
/// darker the diffuse light, the more the lobe matters. (Pixels that need less are diffuse again.)
int materialOrder(const Scene& scene, const Material& material, int sh_order);

/// Classifies every pixel; `irradiance_only`: all as diffuse. Pixels that are too glossy are left
/// to rays, unless a given `sh_order` asks for its truncation.
PixelClasses classifyPixels(const Scene& scene, const GBuffer& gbuffer, int sh_order,
                            bool irradiance_only);

}  // namespace sheen
