// Which pixels pay for what: irradiance only, or spherical harmonics of how many bands.
#pragma once

#include <algorithm>
#include <cstdint>
#include <vector>

#include "cache/record.h"
#include "image/image.h"
#include "raster/gbuffer.h"

namespace sheen {

/// Material of a pixel that sees no geometry.
constexpr int kNoMaterial = -1;
/// Order of a pixel that sees no geometry.
constexpr int kNoOrder = -1;
/// A pixel is diffuse where replacing its specular lobe by a cosine of the same albedo is predicted
/// to change it by less than this share.
constexpr float kDiffuseBudget = 0.005f;
/// A material gets the smallest order whose truncated bands are predicted to change its pixels by
/// less than this share. Where they change a pixel by more, seen from where it is, rays correct
/// what its records say (reflectSpecular()).
constexpr float kTruncationBudget = 0.025f;
/// Of these pixels, those with a lobe of a smaller alpha are too glossy for the cache: their rays
/// say all, since what records miss would change from pixel to pixel as much as the light.
constexpr float kTooGlossy = 0.15f;

struct PixelClasses {
    Image<int> materials;    ///< per pixel: the scene's material; kNoMaterial where nothing is seen
    Image<int> orders;       ///< per pixel: kNoOrder, shared::DIFFUSE_ORDER or bands
    Image<uint8_t> by_rays;  ///< 1: rays correct the specular light, or, where the order is that of
                             ///< a diffuse pixel, say all of it
    std::vector<int> material_orders;  ///< per material of the scene
    bool irradiance_only = false;      ///< specular light is not wanted
    int geometry = 0;                  ///< pixels that see geometry
    int diffuse = 0;                   ///< of these, diffuse
    // Of geometry; a given order leaves both to the records.
    int corrected = 0;   ///< missed by the order, so that rays correct the records
    int too_glossy = 0;  ///< likewise, but too glossy for the cache

    /// Whether rays correct what a pixel's records say.
    bool isCorrected(int x, int y) const {
        return by_rays.at(x, y) != 0 && orders.at(x, y) > shared::DIFFUSE_ORDER;
    }
    /// Whether rays say all of a pixel's specular light.
    bool isTooGlossy(int pixel) const {
        const auto i = static_cast<size_t>(pixel);
        return by_rays.pixels[i] != 0 && orders.pixels[i] == shared::DIFFUSE_ORDER;
    }
    bool anyByRays() const {
        return std::any_of(by_rays.pixels.begin(), by_rays.pixels.end(),
                           [](uint8_t by_ray) { return by_ray != 0; });
    }
};

/// The order that `sh_order` (0: by prediction) gives a material; shared::DIFFUSE_ORDER for one
/// whose specular lobe never matters.
int materialOrder(const MaterialParams& material, int sh_order);
/// The same of a material with its textures, by so dark and smooth a texel that one in twenty is
/// darker or smoother: the darker the diffuse light, the more the lobe matters. (Pixels that need
/// less are diffuse again.)
int materialOrder(const Scene& scene, const Material& material, int sh_order);

/// Classifies every pixel; `irradiance_only`: all as diffuse. None goes by rays where a given
/// `sh_order` asks for its truncation.
PixelClasses classifyPixels(const Scene& scene, const GBuffer& gbuffer, int sh_order,
                            bool irradiance_only);

}  // namespace sheen
